"""Fillets and chamfers of two lines."""

from __future__ import annotations

from math import hypot
from typing import NamedTuple

from arael.sketch.geometry.circular import Arc
from arael.sketch.geometry.coordinates import intersect
from arael.sketch.geometry.line import Line
from arael.sketch.geometry.vectors import Point, cross, dot, gap, subtract, unit


class Corner(NamedTuple):
    """Where two lines meet: the point, and unit directions from it along the lines."""

    point: Point
    first: Point
    second: Point


class Fillet(NamedTuple):
    """Arc tangent to both lines, and the distance from the corner at which it leaves them."""

    arc: Arc
    contacts: tuple[Point, Point]
    trim: float


def corner(a: Line, b: Line) -> Corner | None:
    """Corner of two lines, seen towards the ends that are further from it; None if parallel."""
    at = intersect(a, b)
    if at is None:
        return None
    return Corner(at, _away(a, at), _away(b, at))


def _away(line: Line, at: Point) -> Point:
    far = line.p1 if gap(line.p1, at) > gap(line.p2, at) else line.p2
    return unit(subtract(far, at))


def fillet(at: Corner, radius: float) -> Fillet | None:
    """Arc of a radius in a corner, counter-clockwise; None if the lines are in one direction.

    With the angle w between the directions the arc leaves the lines at r / tan(w / 2).
    """
    c, s = dot(at.first, at.second), cross(at.first, at.second)
    if abs(s) < 1e-12:
        return None
    trim = radius * (1.0 + c) / abs(s)  # 1 / tan(w / 2) = (1 + cos w) / sin w
    p = _move(at.point, at.first, trim)
    q = _move(at.point, at.second, trim)
    far = hypot(radius, trim)
    toward = unit((at.first[0] + at.second[0], at.first[1] + at.second[1]))
    center = _move(at.point, toward, far)
    # the arc bulges towards the corner: it runs counter-clockwise from q to p if the second
    # direction is to the left of the first
    start, end = (q, p) if s > 0 else (p, q)
    return Fillet(Arc.between(center, start, end, radius), (p, q), trim)


def chamfer(at: Corner, first: float, second: float | None = None) -> Line:
    """Segment that cuts a corner off at distances along the two lines."""
    other = first if second is None else second
    return Line(_move(at.point, at.first, first), _move(at.point, at.second, other))


def _move(p: Point, d: Point, length: float) -> Point:
    return p[0] + length * d[0], p[1] + length * d[1]
