"""Formats by suffix; files are written whole or not at all."""

from __future__ import annotations

import builtins
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from arael.diagnostics.explain import codes
from arael.diagnostics.records import AraelError
from arael.sketch.document.document import Document
from arael.sketch.document.saved import to_json
from arael.sketch.drawing import Path as Path_
from arael.sketch.drawing import Text, layout
from arael.sketch.exchange import Imported, read, write
from arael.sketch.exchange.sheet import Sheet, on_sheet
from arael.sketch.exchange.step import inside
from arael.sketch.exchange.units import MILLIMETRES
from arael.sketch.geometry import Arc, Line
from tests.optional import needs, require
from tests.sketch.exchange.sketches import plate


def code_of(caught: pytest.ExceptionInfo[AraelError]) -> str:
    return caught.value.diagnostics[0].code


def test_json_is_the_document(tmp_path: Path) -> None:
    path = tmp_path / "plate.json"
    write(plate(), path)
    again = read(path)
    assert isinstance(again, Document)
    assert to_json(again) == to_json(plate())


@pytest.mark.parametrize("name", ["plate.dfx", "plate", "plate.dwg"])
def test_unknown_suffixes_name_the_known_ones(name: str, tmp_path: Path) -> None:
    with pytest.raises(AraelError) as caught:
        write(plate(), tmp_path / name)
    assert code_of(caught) == "E1301"
    assert ".dxf" in str(caught.value)
    with pytest.raises(AraelError):
        read(tmp_path / name)
    assert not list(tmp_path.iterdir())


def test_pictures_are_written_but_not_read(tmp_path: Path) -> None:
    with pytest.raises(AraelError) as caught:
        read(tmp_path / "plate.png")
    assert code_of(caught) == "E1301"


@needs("matplotlib")
def test_pdf_and_png(tmp_path: Path) -> None:
    for name, head in (("plate.pdf", b"%PDF"), ("plate.png", b"\x89PNG")):
        write(plate(), tmp_path / name)
        assert (tmp_path / name).read_bytes().startswith(head)


@needs("matplotlib")
def test_a_pdf_is_at_full_size(tmp_path: Path) -> None:
    write(plate(), tmp_path / "plate.pdf")
    data = (tmp_path / "plate.pdf").read_bytes()
    box = data[data.index(b"/MediaBox") :][:60].split(b"[")[1].split(b"]")[0].split()
    # 87 mm of geometry and a margin of 70/96 inch on every side
    width = 72 * (87 / 25.4 + 2 * 70 / 96)
    assert float(box[2]) == pytest.approx(width, abs=0.5)


def bar(dx: float, dy: float, unit: str = "mm") -> Document:
    """A line."""
    document = Document()
    with document.transaction("bar"):
        document.set_setting("unit", unit)
        document.add_entity("line", (5.0, 7.0, 5.0 + dx, 7.0 + dy))
    return document


def media_box(data: bytes) -> list[float]:
    """Width and height of the page of a PDF, millimetres."""
    box = data[data.index(b"/MediaBox") :][:60].split(b"[")[1].split(b"]")[0].split()
    return [25.4 / 72 * float(side) for side in box[2:]]


@needs("matplotlib")
def test_a_sheet_has_the_size_of_its_paper_and_a_title_block(tmp_path: Path) -> None:
    write(plate(), tmp_path / "a.pdf", sheet="A3", title="Plate", date="2026-01-31")
    assert media_box((tmp_path / "a.pdf").read_bytes()) == pytest.approx([420, 297], abs=0.1)
    tower = bar(0.0, 200.0)
    write(tower, tmp_path / "b.pdf", sheet="A4")
    assert media_box((tmp_path / "b.pdf").read_bytes()) == pytest.approx([210, 297], abs=0.1)


@pytest.mark.parametrize(
    ("length", "unit", "sheet", "scale"),
    [(100.0, "mm", "A4", "2:1"), (240.0, "mm", "A4", "1:2"), (240.0, "mm", "A3", "1:1"),
     (1.0, "mm", "A4", "200:1"), (30.0, "m", "A1", "1:50"), (4.0, "in", "A4", "2:1")],
)  # fmt: skip
def test_the_scale_of_a_sheet_is_the_largest_standard_one_that_fits(
    length: float, unit: str, sheet: Sheet, scale: str
) -> None:
    document = bar(length, 0.0, unit)
    drawing = on_sheet(document, sheet, "Bar", "2026-01-31")
    texts = [item.text for item in drawing.items if isinstance(item, Text)]
    for expected in ("Bar", unit, scale, "2026-01-31"):
        assert expected in texts
    drawn = next(item for item in drawing.items if isinstance(item, Path_) and item.name == "L0")
    (_, (x1, y1)), (_, (x2, y2)) = drawn.segments
    number, _, of = scale.partition(":")
    millimetres = MILLIMETRES[unit] * length * float(number) / float(of)
    assert 25.4 / 96 * (x2 - x1) == pytest.approx(millimetres)
    assert 0 < x1 < x2 < drawing.width and 0 < y1 == y2 < drawing.height


def test_a_drawing_for_the_shop_has_no_marks_of_the_editor() -> None:
    document = plate()
    value = document.dimensions["d0"].value
    assert value is not None
    formula = replace(value, text="60 + w")
    with document.transaction("formula"):
        document.put("dimensions", replace(document.dimensions["d0"], value=formula))
    marked = layout(document)
    assert any("ƒ" in item.text for item in marked.items if isinstance(item, Text))
    for item in on_sheet(document, "A4").items:
        assert not (isinstance(item, Text) and "ƒ" in item.text)
        # No points, poles or badges: what is filled are arrows.
        assert not isinstance(item, Path_) or item.fill in ("", "dimension", "derived")


@pytest.mark.parametrize(
    ("library", "suffix"), [("ezdxf", "dxf"), ("matplotlib", "png"), ("build123d", "step")]
)
def test_a_missing_library_is_named_and_no_file_is_left(
    library: str, suffix: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    original = builtins.__import__

    def without(name: str, *args: Any, **kwargs: Any) -> Any:
        if name.partition(".")[0] == library:
            raise ImportError(name)
        return original(name, *args, **kwargs)

    monkeypatch.setattr(builtins, "__import__", without)
    path = tmp_path / f"plate.{suffix}"
    path.write_text("old")
    with pytest.raises(AraelError) as caught:
        write(plate(), path)
    assert code_of(caught) == "E1305"
    assert "pip install" in str(caught.value)
    assert path.read_text() == "old"
    if suffix == "dxf":
        with pytest.raises(AraelError) as caught:
            read(path)
        assert code_of(caught) == "E1305"


def test_a_failed_write_keeps_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "plate.svg"
    path.write_text("old")
    monkeypatch.setattr("arael.sketch.exchange.svg.writer.element", lambda _: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        write(plate(), path)
    assert path.read_text() == "old"
    assert len(list(tmp_path.iterdir())) == 1


def test_an_empty_sketch_is_an_empty_drawing(tmp_path: Path) -> None:
    write(Document(), tmp_path / "empty.svg")
    found = read(tmp_path / "empty.svg")
    assert isinstance(found, Imported)
    assert not found.document.entities


def test_every_code_of_files_has_a_page() -> None:
    root = Path(__file__).parents[3] / "arael" / "sketch" / "exchange"
    text = "".join(path.read_text() for path in root.rglob("*.py"))
    used = {f"E{n}" for n in range(1300, 1320) if f'"E{n}"' in text}
    assert used == {"E1301", "E1302", "E1303", "E1305", "E1307"}
    assert used <= set(codes())


def test_points_inside_of_closed_chains() -> None:
    half = [Line((0, 0), (4, 0)), Arc((2, 0), 2, 0, 3.141592653589793)]
    assert inside((2, 1), half)
    assert not inside((2, 3), half)
    assert not inside((-1, 1), half)


@needs("build123d")
def test_step_files_have_faces_with_holes_and_wires(tmp_path: Path) -> None:
    b3d = require("build123d")
    document = Document()
    corners = [(0.0, 0.0), (60.0, 0.0), (60.0, 40.0), (0.0, 40.0)]
    with document.transaction("draw"):
        document.set_setting("unit", "cm")
        for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
            document.add_entity("line", [*a, *b])
        document.add_entity("circle", [20, 20, 8])
        document.add_entity("circle", [20, 20, 3])
        document.add_entity("ellipse", [45, 20, 8, 4, 0.3])
        document.add_entity("line", [100, 0, 120, 0])
        document.add_entity("arc", [120, 10, 120, 0, 130, 10, 10])
        document.add_entity("circle", [200, 0, 8], construction=True)
    write(document, tmp_path / "plate.step")
    shape = b3d.import_step(str(tmp_path / "plate.step"))
    island, plate_ = sorted(face.area for face in shape.faces())
    assert island == pytest.approx(100 * math.pi * 9)
    assert plate_ == pytest.approx(100 * (2400 - math.pi * (64 + 32)), rel=1e-5)
    assert len(shape.edges()) == 4 + 2 + 8 + 2


@needs("build123d")
def test_a_step_file_of_nothing_is_refused(tmp_path: Path) -> None:
    with pytest.raises(AraelError) as caught:
        write(Document(), tmp_path / "plate.step")
    assert code_of(caught) == "E1307"
