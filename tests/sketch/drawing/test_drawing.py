"""Pictures of sketches: goldens of small ones, and facts that every picture keeps."""

from __future__ import annotations

import itertools
import json
import math
import re
from pathlib import Path as File
from xml.etree import ElementTree

import msgspec
import numpy as np
import pytest

from arael.sketch.document.document import Document
from arael.sketch.document.kinds import CONSTRAINTS, DIMENSIONS
from arael.sketch.document.records import Amount, Constraint, Dimension
from arael.sketch.drawing import (
    STATES,
    THEMES,
    Layout,
    Path,
    Text,
    View,
    fitted,
    layout,
    to_image,
    to_svg,
)
from arael.sketch.drawing.dimensions import SIZE, text_width
from arael.sketch.drawing.glyphs import HALF
from arael.sketch.drawing.outlines import beziers_of
from arael.sketch.drawing.symbols import SYMBOLS
from arael.sketch.drawing.texts import dimension_text, number_text
from arael.sketch.drawing.view import bounds_of_document
from arael.sketch.geometry import Bezier, Circle, EllipticArc
from arael.sketch.text import height_of
from tests.optional import needs
from tests.sketch.exchange.sketches import plate

GOLDENS = File(__file__).parent / "goldens"


def triangle() -> Document:
    """A right triangle with constraints and dimensions."""
    document = Document()
    with document.transaction("triangle"):
        for numbers in ([0, 0, 40, 0], [40, 0, 0, 30], [0, 30, 0, 0]):
            document.add_entity("line", numbers)
        document.put("constraints", Constraint("CL0H", "horizontal", ("L0",)))
        for args in (("L0.p2", "L1.p1"), ("L1.p2", "L2.p1"), ("L2.p2", "L0.p1")):
            document.put("constraints", Constraint(document.next_name("C"), "coincident", args))
        document.put(
            "constraints", Constraint(document.next_name("C"), "perpendicular", ("L0", "L2"))
        )
        for kind, names, value in (("length", ("L0",), 40.0), ("angle", ("L0", "L1"), 143.13)):
            document.put(
                "dimensions",
                Dimension(document.next_name("d"), kind, names, Amount(str(value), value)),
            )
    return document


def wheel() -> Document:
    """A circle with a hub, its axis, and a derived radius."""
    document = Document()
    with document.transaction("wheel"):
        document.add_entity("circle", [0, 0, 10])
        document.add_entity("circle", [0, 0, 3])
        document.add_entity("line", [-12, 0, 12, 0], construction=True, style="dashdot")
        document.add_entity("point", [0, 10])
        document.put("constraints", Constraint(document.next_name("C"), "concentric", ("A0", "A1")))
        amount = Amount("hub / 2", 3.0)
        document.put("dimensions", Dimension("d0", "diameter", ("A0",), Amount("20", 20.0)))
        document.put("dimensions", Dimension("d1", "radius", ("A1",), amount, derived=True))
    return document


def title() -> Document:
    """A text above a line, one without its base line, one that is construction."""
    document = Document()
    with document.transaction("title"):
        document.add_entity("line", [0, -2, 60, -2])
        document.add_entity("line", [0, 0, 60, 0], text="Ø8 ±0.1 Rg→")
        document.add_entity("line", [5, 20, 30, 30], text="quiet", quiet=True, style="dashed")
        document.add_entity("line", [50, 20, 30, 25], text="back", construction=True)
    return document


PICTURES = {
    "title": (title, {"L1": "free", "L2": "selected"}, "light"),
    "triangle": (triangle, {"L1": "free", "L2": "selected", "C3": "redundant"}, "light"),
    "wheel": (wheel, {"A0": "impossible", "A1": "free", "d0": "impossible"}, "dark"),
}


@pytest.mark.parametrize("name", PICTURES)
def test_small_pictures_are_their_goldens(name: str, update: bool) -> None:
    make, states, theme = PICTURES[name]
    found = to_svg(layout(make(), states, width=400, height=300), theme)  # type: ignore[arg-type]
    path = GOLDENS / f"{name}.svg"
    if update:
        path.write_text(found, encoding="utf-8")
    assert found == path.read_text(encoding="utf-8")


def test_texts_are_inside_the_picture_and_keep_their_base_line_unless_quiet() -> None:
    drawn = layout(title(), width=300, height=200)
    paths = [item for item in drawn.items if isinstance(item, Path) and item.name == "L1"]
    assert len(paths) == 2 and sorted(bool(one.dash) for one in paths) == [False, True]
    quiet = [item for item in drawn.items if isinstance(item, Path) and item.name == "L2"]
    assert [bool(one.dash) for one in quiet] == [False]
    for item in (*paths, *quiet):
        for _, numbers in item.segments:
            assert all(0 <= x <= 300 for x in numbers[::2])
            assert all(0 <= y <= 200 for y in numbers[1::2])


def test_badges_and_dimensions_keep_off_texts_at_any_scale() -> None:
    document = title()
    with document.transaction("more"):
        for name in ("L1", "L2"):
            document.put("constraints", Constraint(f"C{name}H", "horizontal", (name,)))
        value = Amount("60", 60.0)
        document.put("dimensions", Dimension("d0", "length", ("L1",), value))
    drawn = layout(document, width=800, height=600)
    _, badges = boxes(drawn)
    view = fitted(bounds_of_document(document), 800, 600, 64.0)
    (x1, y1), (x2, y2) = view((0.0, 0.0)), view((60.0, height_of("Ø8 ±0.1 Rg→", 60.0)))
    assert len(badges) == 2
    for x, y, w, h in badges:
        assert x + w < x1 or x - w > x2 or y - h > y1 or y + h < y2
    # far inside of a letter nothing takes long
    assert layout(document, view=View(1e7, 0.0, 0.0, 800, 600)).items


@pytest.fixture(scope="module")
def drawing() -> Layout:
    states = dict(zip(plate().entities, itertools.cycle(STATES), strict=False))
    return layout(plate(), states, width=900, height=900)


def boxes(drawing: Layout) -> tuple[list[tuple[float, ...]], list[tuple[float, ...]]]:
    """Centres and half sizes of texts and of badges of constraints."""
    texts = []
    for item in drawing.items:
        if isinstance(item, Text) and item.role != "note":
            w, h = 0.5 * text_width(item.text), 0.5 * SIZE
            c, s = abs(math.cos(item.angle)), abs(math.sin(item.angle))
            texts.append((item.x, item.y, c * w + s * h, s * w + c * h))
    badges = []
    for item in drawing.items:
        if isinstance(item, Path) and item.fill == "glyph.back":
            numbers = [n[i : i + 2] for _, n in item.segments for i in range(0, len(n), 2)]
            xy = np.array(numbers)
            x, y = 0.5 * (xy.min(0) + xy.max(0))
            badges.append((x, y, HALF, HALF))
    return texts, badges


def test_glyphs_and_texts_do_not_overlap(drawing: Layout) -> None:
    texts, badges = boxes(drawing)
    assert len(texts) == 16 and len(badges) >= 12
    pairs = [*itertools.combinations(badges, 2), *itertools.product(texts, badges)]
    for (x, y, w, h), (u, v, a, b) in (*pairs, *itertools.combinations(texts, 2)):
        assert abs(x - u) >= w + a - 1e-9 or abs(y - v) >= h + b - 1e-9


def test_every_kind_of_constraint_has_its_own_symbol() -> None:
    assert set(SYMBOLS) == set(CONSTRAINTS)
    shapes = [tuple(symbol) for symbol in SYMBOLS.values()]
    assert len(set(shapes)) == len(shapes)


def test_every_kind_of_dimension_is_drawn(drawing: Layout) -> None:
    drawn = {item.name for item in drawing.items if isinstance(item, Text)}
    document = plate()
    assert set(document.dimensions) <= drawn
    assert {d.kind for d in document.dimensions.values()} == set(DIMENSIONS)


def test_states_differ_by_shape_and_by_colour() -> None:
    looks = [(look.halo, look.halo_dash, look.end) for look in STATES.values()]
    assert len(set(looks)) == len(looks)
    for theme in THEMES.values():
        colours = [theme[state] for state in (*STATES, "construction")]
        assert len(set(colours)) == len(colours)


@pytest.mark.parametrize("theme", THEMES)
def test_colours_have_contrast_with_the_background(theme: str) -> None:
    def luminance(colour: str) -> float:
        channels = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
        linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in channels]
        return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]

    colours = THEMES[theme]  # type: ignore[index]
    back = luminance(colours["background"])
    for role in (*STATES, "construction", "dimension", "derived", "glyph", "note"):
        light, dark = sorted((luminance(colours[role]), back), reverse=True)
        assert (light + 0.05) / (dark + 0.05) >= 3.5, role


@pytest.mark.parametrize("state", STATES)
def test_a_state_changes_the_picture_without_its_colour(state: str) -> None:
    """With all colours removed, states still look different."""

    def grey(states: dict[str, str]) -> str:
        svg = to_svg(layout(triangle(), states))
        return re.sub(r"#[0-9a-f]{6}", "#000000", svg)

    others = [grey({"L1": other}) for other in STATES if other != state]
    assert grey({"L1": state}) not in others


def test_svg_is_well_formed_and_names_its_elements(drawing: Layout) -> None:
    root = ElementTree.fromstring(to_svg(drawing))
    names = {e.get("data-name") for e in root.iter()}
    document = plate()
    assert {*document.entities, *document.dimensions} <= names
    assert {c for c in document.constraints} <= names
    assert root.get("aria-label") == drawing.title
    assert drawing.title.startswith("Sketch: 6 lines, 2 circles, 2 arcs")


def test_texts_of_users_are_escaped() -> None:
    title = '<script>alert("1")</script>&\x01'
    items = (Text("note", 1, 1, title, name='"><x'),)
    root = ElementTree.fromstring(to_svg(Layout(10, 10, items, title)))
    assert [e.tag.rpartition("}")[2] for e in root] == ["title", "rect", "text"]
    assert root[2].text == title.replace("\x01", "�")
    assert root[2].get("data-name") == '"><x'


def test_a_layout_is_data(drawing: Layout) -> None:
    text = msgspec.json.encode(drawing)
    assert msgspec.json.decode(text, type=Layout) == drawing
    assert json.loads(text)["items"][0]["type"] in ("path", "text")


def test_everything_fits_and_the_scale_bar_has_the_unit(drawing: Layout) -> None:
    for item in drawing.items:
        if isinstance(item, Text):
            assert 0 <= item.x <= 900 and 0 <= item.y <= 900
    assert any(isinstance(i, Text) and i.text == "10 mm" for i in drawing.items)


def test_an_empty_sketch_has_a_picture() -> None:
    drawing = layout(Document())
    assert drawing.items == ()
    assert "Empty sketch" in to_svg(drawing)


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_the_picture_does_not_depend_on_the_scale(scale: float) -> None:
    def shapes(document: Document) -> list[tuple[str, list[float]]]:
        drawing = layout(document, glyphs=False, dimensions=False, scale_bar=False)
        return [(i.role, [x for _, n in i.segments for x in n])
                for i in drawing.items if isinstance(i, Path)]  # fmt: skip

    for (role, a), (other, b) in zip(shapes(plate()), shapes(plate(scale=scale)), strict=True):
        assert role == other
        np.testing.assert_allclose(a, b, atol=1e-6)


def test_degenerate_sketches_have_pictures() -> None:
    document = Document()
    with document.transaction("x"):
        document.add_entity("line", [1, 1, 1, 1])
        document.add_entity("line", [1, 1, 1, 1])
        document.add_entity("circle", [1, 1, 0])
        for kind, args in (("length", ("L0",)), ("angle", ("L0", "L1")), ("radius", ("A0",))):
            amount = Amount("0", 0.0)
            document.put("dimensions", Dimension(document.next_name("d"), kind, args, amount))
        for kind, args in (("tangent", ("L0", "A0")), ("perpendicular", ("L0", "L1")),
                           ("parallel", ("L0", "L1"))):  # fmt: skip
            document.put("constraints", Constraint(document.next_name("C"), kind, args))
    assert "<svg" in to_svg(layout(document))


def test_offset_and_along_place_the_dimension() -> None:
    def text(offset: float | None, along: float | None) -> Text:
        document = Document()
        with document.transaction("x"):
            document.add_entity("line", [0, 0, 40, 0])
            document.put(
                "dimensions",
                Dimension("d0", "length", ("L0",), Amount("40", 40.0), offset=offset, along=along),
            )
        view = View(10.0, 100.0, 300.0, 600.0, 400.0)
        drawing = layout(document, view=view, scale_bar=False)
        return next(i for i in drawing.items if isinstance(i, Text))

    assert text(5, 0).x == pytest.approx(300)
    assert text(5, 0).y == pytest.approx(300 - 50 - 8)
    assert text(-5, 0).y == pytest.approx(300 + 50 - 8)
    assert text(5, 0.25).x == pytest.approx(400)
    assert text(5, -0.5).x == pytest.approx(100)


def test_texts_of_dimensions() -> None:
    def shown(kind: str, args: tuple[str, ...] = ("L0",), **given: object) -> str:
        return dimension_text(Dimension("d0", kind, args, **given), "mm")  # type: ignore[arg-type]

    five = Amount("5", 5.0)
    assert shown("length", value=five) == "5"
    assert shown("length", value=five, derived=True) == "(5)"
    assert shown("radius", value=five) == "R5"
    assert shown("diameter", value=Amount("5 mm", 5.0)) == "⌀5"
    assert shown("angle", value=Amount("30 deg", 30.0)) == "30°"
    assert shown("area", value=five) == "A 5 mm²"
    assert shown("length", value=Amount("w/2", 5.0)) == "ƒ 5"
    assert shown("diameter", value=Amount("2*r", 5.0)) == "⌀ ƒ 5"
    assert shown("arc_length", value=Amount("2*r", 5.0)) == "◠ ƒ 5"
    assert shown("radius", low=five) == "R ≥ 5"
    assert shown("length", value=five, broken="no w") == "5 ⚠"
    assert shown("length", low=five) == "≥ 5"
    assert shown("length", high=five) == "≤ 5"
    assert shown("length", low=five, high=Amount("7", 7.0)) == "5 … 7"
    assert number_text(-1.5) == "−1.5"
    assert number_text(-1e-300) == "−1e−300"
    assert number_text(1 / 3) == "0.333333"


def test_derived_dimensions_show_what_is_measured() -> None:
    drawing = layout(wheel(), measure=lambda d: 3.25)
    assert "(Rƒ" not in "".join(i.text for i in drawing.items if isinstance(i, Text))
    assert any(isinstance(i, Text) and i.text == "(R3.25)" for i in drawing.items)


def test_outlines_of_conics_are_close_to_the_curve() -> None:
    for curve in (Circle((1, 2), 3), EllipticArc((0, 0), 5, 2, 0.4, 1, -5)):
        for piece in beziers_of(curve):
            for t in np.linspace(0, 1, 9):
                assert curve.nearest(Bezier(piece).point_at(t)).distance < 5e-6 * 5


def test_views_center_and_keep_a_margin() -> None:
    view = fitted(bounds_of_document(triangle()), 400, 300, 50)
    assert view((20, 15)) == pytest.approx((200, 150))
    assert view((0, 0)) == pytest.approx((200 - 20 * view.scale, 150 + 15 * view.scale))
    assert view.scale == pytest.approx(min(300 / 40, 200 / 30))


@needs("matplotlib")
def test_images_have_the_size_of_the_layout() -> None:
    drawing = layout(triangle(), width=400, height=300)
    png = to_image(drawing, "png", pixels_per_unit=2)
    assert png[:4] == b"\x89PNG"
    assert int.from_bytes(png[16:20], "big") == 800
    pdf = to_image(drawing, "pdf", "dark")
    assert pdf[:5] == b"%PDF-"
    assert to_image(drawing, "pdf", "dark") == pdf
