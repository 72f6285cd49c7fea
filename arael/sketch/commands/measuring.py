"""`measure`: one entity, or how two lie to each other."""

from __future__ import annotations

import math
from typing import Any

from arael.sketch.commands.describing import point_place, points_of
from arael.sketch.commands.numbers import shown
from arael.sketch.commands.reading import Operand, Words
from arael.sketch.commands.replies import Reply
from arael.sketch.commands.session import Session
from arael.sketch.commands.table import command
from arael.sketch.document.document import Document
from arael.sketch.expressions.properties import ANGLES, PROPERTIES, property_of
from arael.sketch.expressions.shapes import curve_of

_ALIGNED = 1e-6
"""Sine of the angle below which lines count as parallel or perpendicular."""

_TOUCHING = 1e-6
"""Gap, as a part of the size, below which curves touch."""

Facts = dict[str, float | str | bool]


@command(
    "measure",
    group="ask",
    usage=["measure L0", "measure L0 L1", "measure P0 L0", "measure L0 A0"],
    summary="Measure one entity, or how two lie to each other.",
    arguments=("first", "second="),
)
def measure(session: Session, words: Words) -> Reply:
    """Measure one entity or two."""
    one = words.operand()
    other = words.operand() if words else None
    words.end()
    facts = _of_one(session.document, one) if other is None else _of_two(session, one, other)
    lines = [_line(name, value) for name, value in facts.items()]
    return Reply("\n".join(lines), remembered=False, data=facts)


def _line(name: str, value: Any) -> str:
    if name == "gap" and value < 0.0:  # curves that cross: by how much they are too near
        name, value = "overlap", -value
    return f"{name.replace('_', ' ')}: {_text(name, value)}"


def _text(name: str, value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, str):
        return value
    angle = name in ANGLES or name.endswith("angle")
    return f"{shown(value)}{' deg' if angle else ''}"


def _of_one(document: Document, one: Operand) -> Facts:
    if one.point or one.entity.kind == "point":
        return {one.handle: point_place(document, one.handle)}
    facts: Facts = {}
    for name in PROPERTIES[one.entity.kind]:
        value = property_of(document, one.entity, name)
        assert value is not None
        facts[name] = value
    if "length" not in facts:
        facts["length"] = curve_of(document, one.entity).length()
    for handle in points_of(one.entity):
        facts[handle] = point_place(document, handle)
    return facts


def _is_point(one: Operand) -> bool:
    return bool(one.point) or one.entity.kind == "point"


def _place(document: Document, handle: str) -> tuple[float, float]:
    at = document.point_at(handle)
    x, y = document.values[at : at + 2].tolist()
    return x, y


def _of_two(session: Session, one: Operand, other: Operand) -> Facts:
    document = session.document
    if _is_point(one) and _is_point(other):
        (x1, y1), (x2, y2) = _place(document, one.handle), _place(document, other.handle)
        return {"distance": math.hypot(x2 - x1, y2 - y1), "dx": x2 - x1, "dy": y2 - y1}
    if _is_point(other):
        one, other = other, one
    if _is_point(one):
        return _point_and_curve(document, one, other)
    kinds = {one.entity.kind, other.entity.kind}
    if kinds == {"line"}:
        return _lines(document, one, other)
    if kinds <= {"line", "circle", "arc"}:
        return _with_circle(document, one, other)
    return {"distance": _gap(document, one, other)}


def _point_and_curve(document: Document, point: Operand, other: Operand) -> Facts:
    at = _place(document, point.handle)
    curve = curve_of(document, other.entity)
    facts: Facts = {}
    if other.entity.kind == "line":
        facts["perpendicular_distance"] = curve.nearest(at, carrier=True).distance
    facts["distance"] = curve.nearest(at).distance
    return facts


def _lines(document: Document, one: Operand, other: Operand) -> Facts:
    u, v = (curve_of(document, o.entity).tangent_at(0.0) for o in (one, other))
    cross, dot = u[0] * v[1] - u[1] * v[0], u[0] * v[0] + u[1] * v[1]
    angle = abs(math.degrees(math.atan2(cross, dot)))
    facts: Facts = {
        "angle": angle,
        "supplementary_angle": 180.0 - angle,
        "parallel": abs(cross) < _ALIGNED,
        "perpendicular": abs(dot) < _ALIGNED,
    }
    if facts["parallel"]:
        start = curve_of(document, other.entity).point_at(0.0)
        line = curve_of(document, one.entity)
        facts["perpendicular_distance"] = line.nearest(start, carrier=True).distance
    facts["distance"] = _gap(document, one, other)
    return facts


def _circle(document: Document, one: Operand) -> tuple[tuple[float, float], float]:
    radius = property_of(document, one.entity, "radius")
    assert radius is not None
    return _place(document, f"{one.entity.name}.center"), radius


def _with_circle(document: Document, one: Operand, other: Operand) -> Facts:
    if other.entity.kind == "line":
        one, other = other, one
    center, radius = _circle(document, other)
    if one.entity.kind == "line":
        line = curve_of(document, one.entity)
        distance = line.nearest(center, carrier=True).distance
        touching = abs(distance - radius) <= _TOUCHING * max(radius, distance)
        return {"center_distance": distance, "gap": distance - radius, "tangent": touching}
    first, first_radius = _circle(document, one)
    distance = math.dist(first, center)
    gap = distance - first_radius - radius
    inner = abs(first_radius - radius) - distance
    size = max(first_radius, radius, distance)
    return {
        "center_distance": distance,
        "gap": gap,
        "concentric": distance <= _TOUCHING * size,
        "tangent": min(abs(gap), abs(inner)) <= _TOUCHING * size,
    }


def _gap(document: Document, one: Operand, other: Operand) -> float:
    """Least distance of two curves: 0 where they meet, else from the ends and samples of each."""
    # imported here: start-up time
    from arael.sketch.geometry import intersections

    a, b = (curve_of(document, o.entity) for o in (one, other))
    if intersections(a, b):
        return 0.0
    found = math.inf
    for c, d in ((a, b), (b, a)):
        size = max(c.length(), 1e-300)
        for point in [c.point_at(0.0), c.point_at(1.0), *c.sample(1e-3 * size)]:
            found = min(found, d.nearest(point).distance)
    return found
