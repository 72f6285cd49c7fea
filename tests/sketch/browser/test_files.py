"""Export of every format from the menu, import, and what is reported where a library is absent."""

from __future__ import annotations

import io
import struct
import sys
import xml.etree.ElementTree as xml
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests import optional
from tests.sketch.browser.exercised import exercises
from tests.sketch.browser.panels import names, run, wait

NEEDS = {"dxf": "ezdxf", "pdf": "matplotlib", "png": "matplotlib", "step": "build123d"}


@pytest.fixture
def page(sheet: Any) -> Any:
    run(sheet, "add_rect 0,0 40,20 hv", "add_circle 12,10 4", "length L0 40")
    return sheet


def choose(page: Any, item: str) -> None:
    """An item of the menu of files."""
    page.get_by_role("menuitem", name="File", exact=True).click()
    page.locator(".menu:not([hidden])").get_by_text(item, exact=True).click()


def dxf(content: bytes) -> bool:
    document = optional.require("ezdxf").read(io.StringIO(content.decode()))
    kinds = sorted(one.dxftype() for one in document.modelspace())
    return [kind for kind in kinds if kind in ("LINE", "CIRCLE")] == ["CIRCLE", *["LINE"] * 4]


def svg(content: bytes) -> bool:
    tags = [one.tag.split("}")[1] for one in xml.fromstring(content).iter()]
    return [tag for tag in tags if tag in ("line", "circle")] == [*["line"] * 4, "circle"]


def pdf(content: bytes) -> bool:
    return content.startswith(b"%PDF-") and content.rstrip().endswith(b"%%EOF")


def png(content: bytes) -> bool:
    width, height = struct.unpack(">II", content[16:24])
    return content.startswith(b"\x89PNG\r\n\x1a\n") and width > 100 and height > 100


def step(content: bytes) -> bool:
    text = content.decode()
    return text.startswith("ISO-10303-21") and "CIRCLE" in text and text.count("LINE(") >= 4


def saved(content: bytes) -> bool:
    from arael.sketch.document.saved import from_json

    document = from_json(content)
    return len(document.entities) == 5 and list(document.dimensions) == ["d0"]


CONTENTS: dict[str, Callable[[bytes], bool]] = {
    "dxf": dxf,
    "svg": svg,
    "pdf": pdf,
    "png": png,
    "step": step,
    "json": saved,
}


def formats() -> list[Any]:
    """Formats, those of an optional part marked as such."""
    return [
        pytest.param(one, marks=optional.needs(NEEDS[one])) if one in NEEDS else one
        for one in CONTENTS
    ]


@exercises(*(f"export:{one}" for one in CONTENTS), *(f"action:export_{one}" for one in CONTENTS))
@pytest.mark.parametrize("kind", formats())
def test_the_drawing_is_exported_from_the_menu(page: Any, kind: str) -> None:
    with page.expect_download() as waiting:
        choose(page, f"Export {kind.upper()}")
    download = waiting.value
    assert download.suggested_filename == f"sketch.{kind}"
    assert CONTENTS[kind](Path(download.path()).read_bytes())
    page.get_by_text(f"Exported sketch.{kind}").wait_for()


@optional.needs("ezdxf")
def test_a_display_unit_changes_nothing_in_exported_files(page: Any) -> None:
    def exported(kind: str) -> bytes:
        with page.expect_download() as waiting:
            choose(page, f"Export {kind}")
        return Path(waiting.value.path()).read_bytes()

    def outline(content: bytes) -> Any:
        drawing = optional.require("ezdxf").read(io.StringIO(content.decode()))
        lines = drawing.modelspace().query("LINE")
        return drawing.header["$INSUNITS"], [(one.dxf.start, one.dxf.end) for one in lines]

    before = exported("SVG"), outline(exported("DXF"))
    page.evaluate("app.showLengths('in')")
    assert (exported("SVG"), outline(exported("DXF"))) == before
    assert len(before[1][1]) > 0 and before[1][0] == 4  # millimetres


@exercises(*(f"action:export_{size}" for size in ("a4", "a3", "a2", "a1")))
@optional.needs("matplotlib")
@pytest.mark.parametrize(("size", "long"), [("A4", 297), ("A3", 420), ("A2", 594), ("A1", 841)])
def test_a_sheet_is_exported_from_the_menu(page: Any, size: str, long: float) -> None:
    with page.expect_download() as waiting:
        choose(page, f"Export a sheet {size} as PDF")
    content = Path(waiting.value.path()).read_bytes()
    box = content[content.index(b"/MediaBox") :][:60].split(b"[")[1].split(b"]")[0].split()
    assert max(float(side) for side in box) == pytest.approx(72 * long / 25.4, abs=0.5)


@pytest.mark.parametrize("kind", ["dxf", "step"])
def test_where_a_library_is_absent_the_message_names_what_installs_it(
    page: Any, kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, NEEDS[kind], None)
    choose(page, f"Export {kind.upper()}")
    note = page.locator(".note.error")
    note.wait_for()
    extra = {"dxf": "sketch", "step": "step"}[kind]
    assert f"arael[{extra}]" in note.inner_text()
    assert "Traceback" not in note.inner_text()


@exercises("import:svg")
def test_a_drawing_is_imported_and_its_relations_are_offered(sheet: Any) -> None:
    drawing = (
        "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 30 30'>"
        "<path d='M0 0 H20 V10' fill='none' stroke='black'/></svg>"
    )
    sheet.locator("input[type=file]").set_input_files(
        {"name": "part.svg", "mimeType": "image/svg+xml", "buffer": drawing.encode()}
    )
    sheet.get_by_role("dialog", name="relations that were found").wait_for()
    assert len(names(sheet, "entities")) == 2
    kinds = sheet.locator(".suggestions summary").all_inner_texts()
    assert sorted(text.strip() for text in kinds) == ["1 coincident", "1 horizontal", "1 vertical"]
    sheet.get_by_role("checkbox", name="all vertical").uncheck()
    sheet.get_by_role("button", name="Accept").click()
    wait(sheet, "app.store.constraints.size >= 2")
    found = "[...app.store.constraints.values()].map((one) => one.kind).sort().join(' ')"
    assert sheet.evaluate(found) == "coincident horizontal"


@exercises("import:dxf", "action:import", "key:Ctrl+O")
def chooser(page: Any, key: str) -> Any:
    """The dialogue for files that a key opens.

    The browser opens none while an earlier one is being closed, nor for a key that it has taken too
    long to handle, and says nothing then: a person presses the key again, and so does this.
    """
    opened: list[Any] = []
    page.once("filechooser", lambda one: opened.append(one))
    wait(page, "document.activeElement === app.canvas")
    for _ in range(5):
        page.keyboard.press(key)
        for _ in range(100):
            if opened:
                return opened[0]
            page.wait_for_timeout(50)
    raise AssertionError(f"{key} opens no dialogue for files")


def test_a_dxf_is_imported_by_the_key_that_asks_for_a_file(sheet: Any) -> None:
    ezdxf = optional.require("ezdxf")
    document = ezdxf.new()
    document.modelspace().add_line((0, 0), (20, 0))
    document.modelspace().add_circle((5, 5), 3)
    text = io.StringIO()
    document.write(text)
    chooser(sheet, "Control+o").set_files(
        {"name": "part.dxf", "mimeType": "image/vnd.dxf", "buffer": text.getvalue().encode()}
    )
    wait(sheet, "app.store.entities.size === 2")
    kinds = sheet.evaluate("[...app.store.entities.values()].map((one) => one.kind).sort()")
    assert kinds == ["circle", "line"]


def test_a_file_that_is_none_is_refused_with_its_reason(sheet: Any) -> None:
    run(sheet, "add_point 1,1")
    sheet.locator("input[type=file]").set_input_files(
        {"name": "part.svg", "mimeType": "image/svg+xml", "buffer": b"<not svg"}
    )
    note = sheet.locator(".note.error")
    note.wait_for()
    assert "svg" in note.inner_text().lower()
    assert names(sheet, "entities") == ["P0"]
