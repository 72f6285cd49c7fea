"""SVG files: geometry to scale out, and the shapes of SVG in."""

from __future__ import annotations

import math
from pathlib import Path
from xml.etree import ElementTree

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from arael.diagnostics.records import AraelError
from arael.sketch.document.document import Document
from arael.sketch.exchange import Imported, read, write
from arael.sketch.exchange.svg.paths import PathError, path_curves, transform_of
from arael.sketch.exchange.svg.reader import from_svg
from arael.sketch.exchange.svg.writer import to_svg
from arael.sketch.geometry import Arc, Bezier, Curve, EllipticArc, Line, curve_of
from tests.sketch.exchange.sketches import plate


def svg(body: str, page: str = 'width="100mm" height="100mm" viewBox="0 0 100 100"') -> Imported:
    return from_svg(f'<svg xmlns="http://www.w3.org/2000/svg" {page}>{body}</svg>'.encode())


def curves(found: Imported) -> list[Curve]:
    document = found.document
    return [
        curve_of(e.kind, document.numbers_of(n).tolist())
        for n, e in document.entities.items()
        if e.kind != "point"
    ]


@pytest.mark.parametrize("scale", [1e-3, 1, 1e3])
@pytest.mark.parametrize("unit", ["mm", "in"])
def test_geometry_comes_back_to_scale(unit: str, scale: float) -> None:
    document = plate(unit, scale=scale)
    found = from_svg(to_svg(document).encode())
    assert found.notes == []
    factor = {"mm": 1, "in": 25.4}[unit]
    mine = sorted((e.kind, e.construction, e.style) for e in document.entities.values())
    again = sorted((e.kind, e.construction, e.style) for e in found.document.entities.values())
    assert mine == again
    x = [v for n in ("P0",) for v in found.document.numbers_of(n)]
    dx, dy = x[0] - 5 * scale * factor, x[1] - 5 * scale * factor
    others = curves(found)
    for name, entity in document.entities.items():
        if entity.kind == "point":
            continue
        curve = curve_of(entity.kind, document.numbers_of(name).tolist())
        for t in (0.1, 0.4, 0.9):
            u, v = curve.point_at(t)
            at = u * factor + dx, v * factor + dy
            assert min(c.nearest(at).distance for c in others) < 1e-8 * scale * factor


def test_the_file_is_well_formed_and_in_millimetres(tmp_path: Path) -> None:
    path = tmp_path / "plate.svg"
    write(plate("in"), path)
    root = ElementTree.parse(path).getroot()
    assert root.get("width", "").endswith("mm")
    names = [e.get("data-name") for e in root.iter() if e.get("data-name")]
    assert len(names) == 16
    assert isinstance(read(path), Imported)


PATHS = {
    "lines": ("M0 0L10 0l0 5H3h-3V2v-2z", 6),
    "repeated numbers": ("M0,0 10,0 10,10", 2),
    "relative move": ("m5 5 5 0m1 1 2 0", 2),
    "curves": ("M0 0C1 2 3 4 5 0S9-4 10 0", 2),
    "quadratic curves": ("M0 0Q5 5 10 0T20 0t5 5", 3),
    "arcs without spaces": ("M0 0a5 5 0 01 5 5 5 5 0 10 5 5", 2),
    "exponents and dots": ("M.5.5L1e1-.5", 1),
    "closed twice": ("M0 0L1 0L1 1zM5 5L6 5z", 5),
}


@pytest.mark.parametrize("name", PATHS)
def test_paths_follow_the_grammar(name: str) -> None:
    data, count = PATHS[name]
    found = list(path_curves(data))
    assert len(found) == count


def test_curves_of_paths_are_where_svg_draws_them() -> None:
    first, second = path_curves("M0 0C1 2 3 4 5 0S9-4 10 0")
    assert isinstance(second, Bezier)
    assert second.poles == ((5, 0), (7, -4), (9, -4), (10, 0))
    (quadratic,) = path_curves("M0 0Q5 6 10 0")
    assert quadratic.point_at(0.5) == pytest.approx((5, 3))
    assert first.end == (5, 0)
    (arc,) = path_curves("M0 0A5 5 0 0 1 10 0")
    assert isinstance(arc, Arc)
    assert arc.point_at(0.5) == pytest.approx((5, -5))  # y downwards: clockwise as seen
    (oval,) = path_curves("M0 0A5 2 30 1 0 6 0")
    assert isinstance(oval, EllipticArc)
    assert abs(oval.sweep) > math.pi
    assert list(path_curves("M1 1A0 5 0 0 1 3 3")) == [Line((1, 1), (3, 3))]


BAD = ["L1 1", "M1", "M0 0L1", "M0 0A5 5 0 2 0 1 1", "M0 0X", "1 2", "M0 0LL"]


@pytest.mark.parametrize("data", BAD)
def test_bad_paths_are_reported(data: str) -> None:
    with pytest.raises(PathError):
        list(path_curves(data))


def test_the_part_of_a_path_before_its_mistake_is_read() -> None:
    found = svg('<path d="M0 0L10 0L"/>')
    assert len(curves(found)) == 1
    assert "too few numbers" in found.notes[0]


@given(st.text(alphabet="MmLlHhVvCcSsQqTtAaZz0123456789.-+eE, ", max_size=60))
@settings(max_examples=300, deadline=None)
def test_any_text_is_a_path_or_a_mistake(data: str) -> None:
    try:
        for curve in path_curves(data):
            assert curve.start is not None
    except (PathError, OverflowError):
        pass


def test_transforms_nest_and_y_points_up() -> None:
    found = svg(
        '<g transform="translate(10 20)"><g transform="rotate(90)">'
        '<line x1="0" y1="0" x2="5" y2="0"/></g></g>'
    )
    (line,) = curves(found)
    assert line.start == pytest.approx((10, 80))
    assert line.end == pytest.approx((10, 75))


def test_transforms_of_every_kind() -> None:
    assert transform_of("translate(1)")((0, 0)) == (1, 0)
    assert transform_of("scale(2, 3)")((1, 1)) == (2, 3)
    assert transform_of("rotate(90 1 1)")((2, 1)) == pytest.approx((1, 2))
    assert transform_of("matrix(1 2 3 4 5 6)")((1, 1)) == (9, 12)
    assert transform_of("skewX(45)")((0, 1)) == pytest.approx((1, 1))
    assert transform_of("skewY(45)")((1, 0)) == pytest.approx((1, 1))
    for bad in ("turn(3)", "rotate(1 2)", "translate(1 2", "x"):
        with pytest.raises(PathError):
            transform_of(bad)


def test_circles_under_unequal_scales_are_ellipses() -> None:
    found = svg('<circle cx="10" cy="10" r="2" transform="scale(2 1)"/>')
    assert [e.kind for e in found.document.entities.values()] == ["ellipse"]
    assert found.document.numbers_of("EA0") == pytest.approx([20, 90, 4, 2, 0])


def test_basic_shapes() -> None:
    found = svg(
        '<rect x="1" y="2" width="10" height="6" rx="2"/>'
        '<polygon points="0,0 5,0 5,5"/><polyline points="0,0 5,0 5,5"/>'
        '<ellipse cx="5" cy="5" rx="3" ry="2"/><circle cx="1" cy="1" r="1"/>'
    )
    kinds = [e.kind for e in found.document.entities.values()]
    assert kinds.count("arc") == 4
    assert kinds.count("line") == 4 + 3 + 2
    assert kinds[-2:] == ["ellipse", "circle"]
    joined = [s for s in found.suggestions if s.kind == "tangent"]
    assert len(joined) >= 8  # the rounded rectangle


PAGES = {
    'width="100mm" viewBox="0 0 100 100"': 10,
    'width="10cm" viewBox="0 0 100 100"': 10,
    'width="1in" viewBox="0 0 10 10"': 25.4,
    'width="72pt" viewBox="0 0 100 100"': 2.54,
    'width="96" viewBox="0 0 96 96"': 10 * 25.4 / 96,
    'viewBox="0 0 96 96"': 10 * 25.4 / 96,
    "": 10 * 25.4 / 96,
    'width="100%" height="50mm" viewBox="0 0 100 100"': 5,
    'width="100mm" height="50mm" viewBox="0 0 100 100"': 5,
}


@pytest.mark.parametrize("page", PAGES)
def test_units_of_the_page(page: str) -> None:
    (line,) = curves(svg('<path d="M0 0h10"/>', page))
    assert line.length() == pytest.approx(PAGES[page])


def test_what_is_not_drawn_is_not_read() -> None:
    found = svg(
        '<defs><path d="M0 0h1"/></defs><g display="none"><path d="M0 0h1"/></g>'
        '<path style="fill:none; display:none" d="M0 0h1"/><text>hello</text><use href="#a"/>'
    )
    assert curves(found) == []
    assert found.notes == ["1 `text` element left out", "1 `use` element left out"]


def refused(text: str | bytes, code: str = "E1302") -> str:
    with pytest.raises(AraelError) as caught:
        from_svg(text.encode() if isinstance(text, str) else text)
    assert caught.value.diagnostics[0].code == code
    return caught.value.diagnostics[0].message


BOMB = '<!DOCTYPE svg [<!ENTITY a "lol">' + "".join(
    f'<!ENTITY {chr(98 + i)} "{f"&{chr(97 + i)};" * 10}">' for i in range(9)
) + "]><svg>&j;</svg>"  # fmt: skip


def test_hostile_files_are_refused() -> None:
    assert "declares the entity `a`" in refused(BOMB)
    outside = '<!DOCTYPE svg [<!ENTITY x SYSTEM "file:///etc/passwd">]><svg>&x;</svg>'
    assert "declares the entity" in refused(outside)
    parameter = '<!DOCTYPE svg [<!ENTITY % p SYSTEM "http://example.com/p"> %p;]><svg/>'
    refused(parameter)
    assert "outermost element is not `svg`" in refused("<html/>")
    assert refused("<svg>")
    assert "empty" in refused("")
    refused(b"\x89PNG\r\n\x1a\n")
    refused("<svg><g></svg>")
    assert "nested too deeply" in refused("<svg>" + "<g>" * 400 + "</g>" * 400 + "</svg>", "E1303")


def test_a_public_document_type_is_no_danger() -> None:
    head = (
        '<?xml version="1.0"?><!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" '
        '"http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd">'
    )
    found = from_svg(
        f'{head}<svg xmlns="http://www.w3.org/2000/svg"><path d="M0 0h9"/></svg>'.encode()
    )
    assert len(curves(found)) == 1


def test_too_many_curves_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("arael.sketch.exchange.building.MAX_ENTITIES", 5)
    many = "".join(f'<path d="M{i} 0h1"/>' for i in range(6))
    assert "more than 5 curves" in refused(f"<svg>{many}</svg>", "E1303")


def test_truncated_files_are_refused() -> None:
    whole = to_svg(plate()).encode()
    for part in (0.1, 0.5, 0.99):
        refused(whole[: int(part * len(whole))])


def test_numbers_without_bounds_are_left_out() -> None:
    found = svg('<path d="M0 0L1e999 0"/><circle cx="0" cy="0" r="0"/><path d="M0 0h1e200"/>')
    assert curves(found) == []
    assert len(found.notes) == 2


def lettered() -> Document:
    document = Document()
    with document.transaction("texts"):
        document.add_entity("line", [0, 0, 30, 10], text='Ø8 "<&>" → \u00e4')
        document.add_entity("line", [5, 20, 30, 20], text="dashed", style="dashed")
        document.add_entity("line", [5, 30, 5, 60], text="M6", construction=True)
    return document


def test_texts_come_back_as_texts() -> None:
    document = lettered()
    found = from_svg(to_svg(document).encode()).document
    mine = [(e.text, e.construction, e.style) for e in document.entities.values()]
    again = [(e.text, e.construction, e.style) for e in found.entities.values()]
    assert sorted(again) == sorted(mine)
    for one in found.entities.values():
        source = next(e.name for e in document.entities.values() if e.text == one.text)
        a, b = document.numbers_of(source), found.numbers_of(one.name)
        assert (b[2:] - b[:2]).tolist() == pytest.approx((a[2:] - a[:2]).tolist())


def test_other_programs_see_the_strokes_of_a_text() -> None:
    plain = to_svg(lettered()).replace("data-text", "data-other")
    found = from_svg(plain.encode()).document
    assert not any(e.text for e in found.entities.values())
    kinds = {e.kind for e in found.entities.values()}
    assert kinds == {"line", "arc", "circle"} or kinds == {"line", "arc"}


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('data-text="M6"', 'data-text="a&#10;b"'),
        ('data-text="M6"', 'data-text="&#x202e;"'),
        ('data-frame="', 'data-frame="nan '),
        ('data-frame="', 'transform="scale(-1 1)" data-frame="'),
        ('data-frame="', 'transform="scale(2 1)" data-frame="'),
    ],
)
def test_what_is_no_text_of_ours_is_read_as_strokes(old: str, new: str) -> None:
    document = Document()
    with document.transaction("text"):
        document.add_entity("line", [0, 0, 30, 0], text="M6")
    text = to_svg(document)
    assert old in text
    found = from_svg(text.replace(old, new).encode()).document
    assert len(found.entities) > 2 and not any(e.text for e in found.entities.values())
