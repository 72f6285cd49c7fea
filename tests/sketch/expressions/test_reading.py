"""Expressions: reading, units, values, errors with their places."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from arael import sym
from arael.diagnostics.records import AraelError
from arael.sketch.document.document import Document
from arael.sketch.document.records import Amount, Dimension, Parameter
from arael.sketch.expressions.evaluation import compiled, evaluate, number, require_quantity
from arael.sketch.expressions.reading import MAX_LENGTH, literal, read
from arael.sketch.expressions.scope import DocumentScope
from arael.sketch.expressions.vectors import Vec


@pytest.fixture
def document() -> Document:
    made = Document()
    with made.transaction("make"):
        made.add_entity("line", (0, 0, 3, 4))
        made.add_entity("arc", (0, 0, 2, 0, 0, 2, 2))
        made.add_entity("circle", (7, 1, 2.5))
        made.add_entity("ellipse", (1, 2, 3, 1, math.radians(30)))
        made.add_entity("earc", (0, 0, 3, 0, 0, 1, 3, 1, 0))
        made.add_entity("point", (8, 9))
        made.add_entity("bezier", (0, 0, 1, 1, 2, 1, 3, 0))
        made.add_entity("arc", (0, 0, 2, 0, 0, 2, 2), clockwise=True)
        made.add_entity("ellipse", (1, 2, 5, 5, 0))
        made.put("parameters", Parameter("w", Amount("10", 10.0)))
        made.put("parameters", Parameter("a", Amount("30 deg", 30.0)))
        made.put("dimensions", Dimension("d0", "length", ("L0",), Amount("5", 5.0)))
        made.put("dimensions", Dimension("d1", "xangle", ("L0",), Amount("53", 53.0)))
    return made


VALUES = {
    "1 + 2*3": 7,
    "2^3^2": 512,
    "-2^2": -4,
    "(1 + 2) * 3": 9,
    "12 mm": 12,
    "12mm": 12,
    "1 cm + 2 mm": 12,
    "0.5 in": 12.7,
    "1 ft": 304.8,
    "2 m": 2000,
    "5 um": 0.005,
    "30 deg": 30,
    "1 rad": math.degrees(1),
    ".5 + .25": 0.75,
    "1e3": 1000,
    "sin(30 deg)": 0.5,
    "cos(a)": math.cos(math.radians(30)),
    "sin(pi/6)": 0.5,
    "tan(L0.angle)": 4 / 3,
    "sin(d1)": math.sin(math.radians(53)),
    "sin(2*a - 30 deg)": 0.5,
    "atan2(4, 3) * 1 rad": math.degrees(math.atan2(4, 3)),
    "sqrt(w^2 + d0^2)": math.sqrt(125),
    "min(w, 3, 5) + max(1, 2)": 5,
    "abs(-3)": 3,
    "if w > 5 then 1 else 2": 1,
    "(if w <= 5 then 1 else 2)*3": 6,
    "L0.length": 5,
    "L0.p2.x * L0.p2.y": 12,
    "A0.radius + A0.diameter": 6,
    "A0.sweep": 90,
    "A0.length": math.pi,
    "A0.start_angle": 0,
    "A0.end_angle": 90,
    "A2.start_angle": 90,
    "A2.start.y": 2,
    "A0.end.y": 2,
    "A1.center.x + A1.radius": 9.5,
    "A1.sweep": 360,
    "EA0.radius + EA0.radius_b": 4,
    "EA0.rotation": 30,
    "EA1.start_angle": 0,
    "EA1.end_angle": 90,
    "P0.x + P0.y": 17,
    "S0.pole2.y + S0.p2.x": 4,
    "EA2.length": 10 * math.pi,
    "S0.length > 3 ": 1,
    "dist(P0, L0.p1)": math.hypot(8, 9),
    "dist(P0, L0)": abs(3 * 9 - 4 * 8) / 5,
    "midpoint(L0).x": 1.5,
    "+".join(["1"] * 999): 999,
    "*".join(["1"] * 999): 1,
    "2*3 - 4/2*(1 - 3)^2 + 1": -1,
}


@pytest.mark.parametrize("text", VALUES)
def test_value(document: Document, text: str) -> None:
    assert number(text, DocumentScope(document)) == pytest.approx(VALUES[text], abs=1e-12)


def test_coordinates(document: Document) -> None:
    scope = DocumentScope(document)
    assert evaluate("P0 + normal(L0)*5", scope) == Vec(8 - 4, 9 + 3)
    assert evaluate("2*L0.p2 - P0/2", scope) == Vec(2, 3.5)
    assert evaluate("arc_point(A0, 90)", scope).y == pytest.approx(2)  # type: ignore[union-attr]


@pytest.mark.parametrize("text", ["w", "a", "12 mm", "30 deg", "L0.length/w"])
def test_units_of_the_document(document: Document, text: str) -> None:
    before = number(text, DocumentScope(document))
    with document.transaction("unit"):
        document.set_setting("unit", "cm")
    after = number(text, DocumentScope(document))
    assert after == pytest.approx(before / 10 if text.endswith("mm") else before)


ERRORS = {
    "12 furlong": ("E0136", 3, 10),
    "3 + foo": ("E1262", 4, 7),
    "L0.lenght": ("E1262", 0, 9),
    "L9.length": ("E1262", 0, 9),
    "12 mm + foo": ("E1262", 8, 11),
    ".5 mm*(3 in) + foo": ("E1262", 15, 18),
    "1/(w - 10)": ("E1263", 0, 10),
    "12 mm + + ": ("E0138", 8, 9),
    "2 ** 3": ("E0110", 2, 4),
    "[1, 2]": ("E1254", 0, 6),
    "w[0]": ("E1254", 0, 4),
    '"text"': ("E1254", 0, 6),
    "not w": ("E1254", 0, 5),
    "sum(3, 4)": ("E0205", 0, 3),
    "P0 * P0": ("E1253", 0, 7),
    "sqrt(P0)": ("E1253", 0, 8),
    "(-8)^0.5": ("E1263", 0, 8),
    "exp(1e9)": ("E1263", 0, 8),
    "1e308*10": ("E1263", 0, 8),
}


@pytest.mark.parametrize("text", ERRORS)
def test_errors_have_their_place(document: Document, text: str) -> None:
    with pytest.raises(AraelError) as caught:
        number(text, DocumentScope(document))
    found = caught.value.diagnostics[0]
    assert found.span is not None
    assert (found.code, found.span.start, found.span.end) == ERRORS[text]
    assert found.span.source.text == text


def test_length_is_bounded() -> None:
    with pytest.raises(AraelError) as caught:
        read("1" + "+1" * MAX_LENGTH)
    assert caught.value.diagnostics[0].code == "E1260"


@pytest.mark.parametrize("text", ["5", "-3.5", "+2", "1e-3", ".5", "5."])
def test_literals(text: str) -> None:
    assert literal(text) == float(text)


@pytest.mark.parametrize("text", ["", "5 mm", "nan", "inf", "1_000", "0x10", "٣", "1e", "--1"])
def test_what_is_no_literal(text: str) -> None:
    assert literal(text) is None


def test_references_with_their_places() -> None:
    found = read("w*2 mm + dist(P0, L0) - L0.p1.x").references
    assert [one.path for one in found] == ["w", "P0", "L0", "L0.p1.x"]
    text = "w*2 mm + dist(P0, L0) - L0.p1.x"
    assert [text[one.start : one.end] for one in found] == [one.path for one in found]


@pytest.mark.parametrize(
    ("text", "quantity"),
    [
        ("12 mm*3 + 1", "length"),
        ("30 deg/2", "angle"),
        ("12 mm/3 mm", ""),
        ("w + 3", ""),
        ("L0.length + 2 mm", "length"),
        ("L0.angle - 5 deg", "angle"),
        ("max(t, 1 deg)", "angle"),
        ("sin(t) * 4 mm", "length"),
        ("L0.p1.x + 3", "length"),
    ],
)
def test_quantities(document: Document, text: str, quantity: str) -> None:
    with document.transaction("parameters"):
        document.put("parameters", Parameter("w", Amount("2", 2.0)))
        document.put("parameters", Parameter("t", Amount("30 deg", 30.0)))
    scope = DocumentScope(document)
    assert compiled(text).quantity(scope) == quantity
    require_quantity(text, quantity)
    other = {"length": "angle", "angle": "length"}.get(quantity)
    if other and any(unit in text for unit in ("mm", "deg")):
        with pytest.raises(AraelError, match="E1261"):
            require_quantity(text, other)


@pytest.mark.parametrize(
    "text",
    ["5 mm + 3 deg", "3 deg - 5 mm", "5 mm + t", "L0.length + L0.angle", "2*(1 mm + 1 rad)",
     "1 mm < 2 deg", "sqrt(5 mm + t)"],
)  # fmt: skip
def test_a_length_and_an_angle_do_not_make_a_sum(document: Document, text: str) -> None:
    with document.transaction("parameters"):
        document.put("parameters", Parameter("t", Amount("30 deg", 30.0)))
    with pytest.raises(AraelError, match="E1261"):
        evaluate(text, DocumentScope(document))


_NUMBERS = st.floats(-9, 9, allow_nan=False).map(lambda x: f"{abs(x):.3f}")
_EXPRESSIONS = st.recursive(
    st.one_of(_NUMBERS, st.sampled_from(["w", "L0.length", "P0.x"])),
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from("+-*/"), inner).map(lambda t: f"({t[0]} {t[1]} {t[2]})"),
        inner.map(lambda t: f"sqrt(abs({t}))"),
        inner.map(lambda t: f"-{t}"),
        st.tuples(inner, inner).map(lambda t: f"max({t[0]}, {t[1]})"),
    ),
    max_leaves=8,
)


@settings(max_examples=60, deadline=None)
@given(_EXPRESSIONS)
def test_values_are_those_of_formulas(text: str) -> None:
    document = Document()
    with document.transaction("make"):
        document.add_entity("line", (0, 0, 3, 4))
        document.add_entity("point", (8, 9))
        document.put("parameters", Parameter("w", Amount("10", 10.0)))
    try:
        found = number(text, DocumentScope(document))
    except AraelError as error:
        assert error.diagnostics[0].code == "E1263"
        return
    value = sym.parse(text)
    names = {"w": 10.0, "L0.length": 5.0, "P0.x": 8.0}
    expected = sym.eval(value, {name: names[name] for name in sym.free_vars(value)})
    assert found == pytest.approx(expected, rel=1e-9, abs=1e-9)
