"""DXF: our sketches come back as they were; foreign drawings bring geometry."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.document.document import Document
from arael.sketch.document.saved import to_json
from arael.sketch.exchange import Imported, read, write
from arael.sketch.exchange.dxf.reader import from_dxf
from arael.sketch.exchange.dxf.writer import to_dxf
from arael.sketch.geometry import Curve, curve_of
from arael.sketch.text import width_of
from tests.optional import needs, require
from tests.sketch.exchange.sketches import plate

pytestmark = needs("ezdxf")


@pytest.fixture(scope="module")
def written() -> bytes:
    require("ezdxf")
    return to_dxf(plate())


def curves(document: Document) -> list[tuple[str, Curve]]:
    return [
        (e.kind, curve_of(e.kind, document.numbers_of(n).tolist()))
        for n, e in document.entities.items()
        if e.kind != "point"
    ]


def foreign(draw: Any, units: int = 4) -> bytes:
    """A drawing that `draw` makes with ezdxf."""
    from io import StringIO

    file = require("ezdxf").new("R2010", setup=True)
    file.header["$INSUNITS"] = units
    draw(file, file.modelspace())
    stream = StringIO()
    file.write(stream)
    return stream.getvalue().encode()


def imported(data: bytes) -> Imported:
    found = from_dxf(data)
    assert isinstance(found, Imported)
    return found


@pytest.mark.parametrize("unit", ["mm", "in"])
@pytest.mark.parametrize(("shift", "scale"), [(0, 1), (1e6, 1), (0, 1e-6), (0, 1e6)])
def test_a_sketch_comes_back_as_the_same_sketch(unit: str, shift: float, scale: float) -> None:
    document = plate(unit, shift, scale)
    again = from_dxf(to_dxf(document))
    assert isinstance(again, Document)
    assert to_json(again) == to_json(document)


def test_the_auditor_of_ezdxf_has_no_finding(written: bytes, tmp_path: Path) -> None:
    path = tmp_path / "plate.dxf"
    path.write_bytes(written)
    auditor = require("ezdxf").readfile(path).audit()
    assert [*auditor.errors, *auditor.fixes] == []


def test_dimensions_are_dimension_entities(written: bytes, tmp_path: Path) -> None:
    path = tmp_path / "plate.dxf"
    path.write_bytes(written)
    space = require("ezdxf").readfile(path).modelspace()
    measured = sorted(
        round(d.get_measurement() if d.dxftype() == "DIMENSION" else 0, 2)
        for d in space.query("DIMENSION")
        if d.dimtype in (0, 1, 3, 4)
    )
    for expected in (60, 40, 15, 25, 8, 16):
        assert expected in measured
    layers = {e.dxf.layer for e in space}
    assert layers == {"OUTLINE", "CONSTRUCTION", "DIMENSIONS"}
    assert [e.dxf.linetype for e in space.query("LINE")][1] == "DASHED"


def test_geometry_alone_survives_without_our_record(written: bytes) -> None:
    text = written.decode().replace("ARAEL_SKETCH", "OTHER_SKETCH")
    found = imported(text.encode())
    mine, other = curves(plate()), curves(found.document)
    assert [kind for kind, _ in mine] == [kind for kind, _ in other]
    for (_, a), (_, b) in zip(mine, other, strict=True):
        for t in (0, 0.3, 1):
            at = a.point_at(t)
            gap = b.nearest(at).distance if a.closed else math.dist(b.point_at(t), at)
            assert gap < 1e-6
    flags = [(e.construction, e.style) for e in found.document.entities.values()]
    assert flags == [(e.construction, e.style) for e in plate().entities.values()]


def test_geometry_that_was_changed_is_imported_without_its_constraints(tmp_path: Path) -> None:
    path = tmp_path / "plate.dxf"
    write(plate(), path)
    file = require("ezdxf").readfile(path)
    file.modelspace().query("CIRCLE")[0].dxf.radius = 9
    file.saveas(path)
    found = read(path)
    assert isinstance(found, Imported)
    assert not found.document.constraints
    assert any("was changed since arael wrote it" in note for note in found.notes)


def test_a_record_that_is_no_sketch_is_left_out(written: bytes) -> None:
    text = written.decode().replace('""parallel""', "").replace("arael-sketch", "arael-skotch")
    found = imported(text.encode())
    assert any("since it cannot be read" in note for note in found.notes)
    assert len(found.document.entities) == 16


def test_units_are_those_of_the_header() -> None:
    def draw(_: Any, space: Any) -> None:
        space.add_line((0, 0), (1, 0))

    cases = ((4, "mm", 1), (5, "cm", 1), (1, "in", 1), (2, "in", 12), (0, "mm", 1))
    for code, unit, length in cases:
        document = imported(foreign(draw, code)).document
        assert document.unit == unit
        assert document.numbers_of("L0")[2] == length
    found = imported(foreign(draw, 20))
    assert "unit of the drawing is unknown" in found.notes[0]


def test_polylines_with_bulges_are_lines_and_arcs() -> None:
    def draw(_: Any, space: Any) -> None:
        space.add_lwpolyline(
            [(0, 0, 0), (4, 0, 1), (4, 2, 0), (0, 2, -1)], format="xyb", close=True
        )

    found = imported(foreign(draw)).document
    kinds = [kind for kind, _ in curves(found)]
    assert kinds == ["line", "arc", "line", "arc"]
    (_, bulge), (_, dent) = (pair for pair in curves(found) if pair[0] == "arc")
    assert bulge.point_at(0.5) == pytest.approx((5, 1))
    assert dent.point_at(0.5) == pytest.approx((1, 1))


def test_blocks_are_exploded_with_their_scale_and_rotation() -> None:
    def draw(file: Any, space: Any) -> None:
        inner = file.blocks.new("INNER")
        inner.add_circle((1, 0), 0.5)
        outer = file.blocks.new("OUTER")
        outer.add_blockref("INNER", (1, 0))
        space.add_blockref("OUTER", (10, 0), dxfattribs={"xscale": 2, "yscale": 2, "rotation": 90})
        space.add_blockref("INNER", (0, 0), dxfattribs={"row_count": 2, "row_spacing": 5})

    found = imported(foreign(draw)).document
    circles = [(c.center, c.radius) for _, c in curves(found)]  # type: ignore[attr-defined]
    assert circles == [
        (pytest.approx((10, 4)), pytest.approx(1)),
        (pytest.approx((1, 0)), 0.5),
        (pytest.approx((1, 5)), 0.5),
    ]


def test_entities_seen_from_below_are_mirrored() -> None:
    def draw(_: Any, space: Any) -> None:
        down = {"extrusion": (0, 0, -1)}
        space.add_arc((-3, 0), 1, 0, 90, dxfattribs=down)
        space.add_circle((-3, 0), 1, dxfattribs={"extrusion": (1, 0, 0)})

    found = imported(foreign(draw))
    ((_, arc),) = curves(found.document)
    assert sorted([arc.start, arc.end]) == [pytest.approx((2, 0)), pytest.approx((3, 1))]
    assert arc.point_at(0.5)[1] > 0
    assert found.notes == ["1 tilted CIRCLE left out"]


def test_splines_of_other_degrees_become_cubic() -> None:
    def draw(_: Any, space: Any) -> None:
        points = [(0, 0), (1, 2), (3, 2), (4, 0), (6, 1)]
        space.add_open_spline(points, degree=2)
        space.add_rational_spline([*points[:4]], weights=[1, 2, 2, 1], degree=3)
        space.add_spline(fit_points=[(0, 9), (2, 8), (4, 9)])

    found = imported(foreign(draw)).document
    kinds = {kind for kind, _ in curves(found)}
    assert kinds <= {"bezier", "bspline"} and len(found.entities) >= 3
    first = next(c for _, c in curves(found))
    assert first.start == pytest.approx((0, 0))


def test_what_a_sketch_has_no_place_for_is_counted() -> None:
    def draw(_: Any, space: Any) -> None:
        space.add_mtext("hello")
        space.add_mtext("world")
        space.add_line((0, 0), (1, 1))

    found = imported(foreign(draw))
    assert found.notes == ["2 MTEXTs left out"]
    assert len(found.document.entities) == 1


def refused(data: bytes, code: str) -> str:
    with pytest.raises(AraelError) as caught:
        from_dxf(data)
    assert caught.value.diagnostics[0].code == code
    return caught.value.diagnostics[0].message


@pytest.mark.parametrize("data", [b"", b"  \n", b"hello", b"\x00" * 500, b"\xff\xfe\x00",
                                  b"  0\nSECTION\n  2\nENTITIES\n  0\nLINE\n"])  # fmt: skip
def test_what_is_no_dxf_is_refused_or_empty(data: bytes) -> None:
    try:
        found = from_dxf(data)
    except AraelError as error:
        assert error.diagnostics[0].code == "E1302"
    else:
        assert isinstance(found, Imported) and not found.document.entities


@pytest.mark.parametrize("part", [0.05, 0.3, 0.6, 0.9, 0.98, 0.9999])
def test_a_file_that_is_cut_short_is_refused(written: bytes, part: float) -> None:
    refused(written[: int(part * len(written))], "E1302")


def test_what_a_file_that_is_cut_short_still_holds_is_said() -> None:
    data = foreign(lambda _, space: [space.add_line((k, 0), (k, 5)) for k in range(5)])
    end = data.index(b"ENDSEC", data.index(b"ENTITIES"))
    message = refused(data[:end], "E1302")
    assert "cut short" in message and "after 5 complete curves" in message


def test_a_block_that_contains_itself_is_refused() -> None:
    def draw(file: Any, space: Any) -> None:
        for name, other in (("A", "B"), ("B", "A")):
            file.blocks.new(name).add_blockref(other, (0, 0))
        space.add_blockref("A", (0, 0))

    assert "contains itself" in refused(foreign(draw), "E1302")


def test_blocks_that_multiply_are_refused() -> None:
    def draw(file: Any, space: Any) -> None:
        file.blocks.new("B0").add_point((0, 0))
        counts = dict.fromkeys(("row_count", "column_count"), 1000)
        counts |= dict.fromkeys(("row_spacing", "column_spacing"), 5)
        space.add_blockref("B0", (0, 0), dxfattribs=counts)

    assert "1,000,000 copies" in refused(foreign(draw), "E1303")


def test_nested_blocks_are_refused_beyond_the_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    def draw(file: Any, space: Any) -> None:
        file.blocks.new("B0").add_point((0, 0))
        for i in range(1, 8):
            file.blocks.new(f"B{i}").add_blockref(f"B{i - 1}", (0, 0))
        space.add_blockref("B7", (0, 0))

    data = foreign(draw)
    assert len(imported(data).document.entities) == 1
    monkeypatch.setattr("arael.sketch.exchange.dxf.reader.MAX_DEPTH", 4)
    assert "nested too deeply" in refused(data, "E1303")
    monkeypatch.setattr("arael.sketch.exchange.dxf.reader.MAX_BYTES", 100)
    assert "bytes" in refused(data, "E1303")


def test_numbers_that_are_not_finite_are_left_out() -> None:
    def draw(_: Any, space: Any) -> None:
        space.add_line((0, 0), (1, 1))
        space.add_circle((123.5, 0), 1)

    data = foreign(draw).replace(b"123.5", b"1e999")
    assert imported(data).notes == ["1 curve without finite numbers left out"]


def test_dimension_lines_are_outside_of_the_drawing(written: bytes, tmp_path: Path) -> None:
    path = tmp_path / "plate.dxf"
    path.write_bytes(written)
    space = require("ezdxf").readfile(path).modelspace()
    width = next(d for d in space.query("DIMENSION") if round(d.get_measurement() or 0) == 60)
    assert width.dxf.defpoint.y < 0


TEXTS = ["M6", "50 %", "5%%d %%%", "^A ^^ ^ x", "Ø8 \u00b10.1 → ש", 'say "hi" \\P {x}', "a;b#c"]


def lettered(unit: str = "mm") -> Document:
    """A sketch of texts, one of them construction."""
    document = Document()
    with document.transaction("texts"):
        document.set_setting("unit", unit)
        for i, text in enumerate(TEXTS):
            numbers = [i, 5.0 * i, 10.0 + i, 5.0 * i + 3.0]
            document.add_entity("line", numbers, text=text, construction=i == 1)
    return document


@pytest.mark.slow
def test_a_sketch_with_texts_comes_back_as_the_same_sketch() -> None:
    document = lettered()
    again = from_dxf(to_dxf(document))
    assert isinstance(again, Document)
    assert to_json(again) == to_json(document)


def test_texts_are_text_entities_between_the_ends_of_their_frames(tmp_path: Path) -> None:
    path = tmp_path / "texts.dxf"
    path.write_bytes(to_dxf(lettered()))
    file = require("ezdxf").readfile(path)
    assert not file.modelspace().query("LINE")
    assert [one.plain_text() for one in file.modelspace().query("TEXT")] == TEXTS
    auditor = file.audit()
    assert [*auditor.errors, *auditor.fixes] == []


def test_texts_survive_without_our_record() -> None:
    data = to_dxf(lettered()).replace(b"ARAEL_SKETCH", b"OTHER_SKETCH")
    document = imported(data).document
    assert [e.text for e in document.entities.values()] == TEXTS
    assert [e.construction for e in document.entities.values()][:3] == [False, True, False]
    assert document.values.tolist() == pytest.approx(lettered().values.tolist())


def test_a_text_that_was_changed_is_imported_as_it_is_now(tmp_path: Path) -> None:
    path = tmp_path / "texts.dxf"
    write(lettered(), path)
    file = require("ezdxf").readfile(path)
    file.modelspace().query("TEXT")[0].dxf.text = "M8"
    file.saveas(path)
    found = read(path)
    assert isinstance(found, Imported)
    assert found.document.entities["L0"].text == "M8"


@pytest.mark.parametrize(
    ("align", "start"),
    [("LEFT", (0, 0)), ("RIGHT", (-1, 0)), ("CENTER", (-0.5, 0)), ("MIDDLE_CENTER", (-0.5, -0.5)),
     ("TOP_LEFT", (0, -1)), ("MIDDLE", (-0.5, -0.5)), ("BOTTOM_RIGHT", (-1, 0.3))],
)  # fmt: skip
def test_texts_of_others_keep_height_and_place(align: str, start: tuple[float, float]) -> None:
    width, height = 5.0 * width_of("abc"), 5.0

    def draw(_: Any, space: Any) -> None:
        alignment = require("ezdxf").enums.TextEntityAlignment[align]
        text = space.add_text("abc", height=height, rotation=90)
        text.set_placement((20, 30), align=alignment)

    (frame,) = [imported(foreign(draw)).document.numbers_of("L0").tolist()]
    across, up = start[0] * width, start[1] * height
    assert frame == pytest.approx([20 - up, 30 + across, 20 - up, 30 + across + width])


def test_texts_that_a_sketch_cannot_hold_are_counted() -> None:
    def draw(_: Any, space: Any) -> None:
        space.add_text("x" * 201)
        space.add_text("   ")
        space.add_text("tilted", dxfattribs={"extrusion": (1, 0, 0)})
        space.add_text("below", dxfattribs={"extrusion": (0, 0, -1)})

    found = imported(foreign(draw))
    assert found.notes == ["4 TEXTs left out"] and not found.document.entities
