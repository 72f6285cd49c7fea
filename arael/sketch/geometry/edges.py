"""Where a distance to the edge of a circle begins and ends."""

from __future__ import annotations

from math import atan2

from arael.sketch.geometry.conic import Conic
from arael.sketch.geometry.coordinates import project
from arael.sketch.geometry.line import Line
from arael.sketch.geometry.vectors import Point


def to_edge(one: Point | Line, circle: Conic) -> tuple[Point, Point]:
    """From a point, or the foot of the centre on a line, to a whole circle."""
    start = project(circle.middle, one) if isinstance(one, Line) else one
    return start, _towards(circle, start)


def between_edges(mode: str, one: Conic, two: Conic) -> tuple[Point, Point]:
    """Where circles ``outside`` of each other, or one ``inside`` the other, are nearest."""
    if mode == "outside":
        return _towards(one, two.middle), _towards(two, one.middle)
    outer, inner = (one, two) if one.radii[0] > two.radii[0] else (two, one)
    a = _towards(outer, inner.middle)
    b = _towards(inner, a)
    return (a, b) if outer is one else (b, a)


def _towards(conic: Conic, p: Point) -> Point:
    x, y = conic.middle
    return conic.at_angle(atan2(p[1] - y, p[0] - x) - conic.turned)
