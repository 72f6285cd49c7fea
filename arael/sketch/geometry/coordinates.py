"""Functions of points and lines, as commands use them for coordinates."""

from __future__ import annotations

from math import cos, sin

from arael.sketch.geometry.conic import Conic
from arael.sketch.geometry.curve import Curve
from arael.sketch.geometry.line import Line
from arael.sketch.geometry.vectors import Point, cross, gap, left, subtract, times, unit


def intersect(a: Line, b: Line) -> Point | None:
    """Point common to two lines, which need not lie on the segments; None if they are parallel."""
    d, e = a.tangent_at(0.0), b.tangent_at(0.0)
    sine = cross(d, e)
    if abs(sine) < 1e-12:
        return None
    s = cross(subtract(b.p1, a.p1), e) / sine
    return a.p1[0] + s * d[0], a.p1[1] + s * d[1]


def midpoint(curve: Curve | Point, other: Point | None = None) -> Point:
    """Middle of a line or an arc (by angle), or of two points."""
    if isinstance(curve, Curve):
        return curve.point_at(0.5)
    if other is None:
        raise TypeError("midpoint needs a curve, or two points")
    return 0.5 * (curve[0] + other[0]), 0.5 * (curve[1] + other[1])


def project(point: Point, curve: Curve) -> Point:
    """Foot of a point on a line (also beyond its ends), circle or ellipse; nearest on a spline."""
    return curve.point_at(curve.nearest(point, carrier=True).t)


def along(curve: Curve, fraction: float) -> Point:
    """Point at a fraction of a line or arc: 0 is its start, 1 its end."""
    return curve.point_at(fraction)


def arc_point(conic: Conic, angle: float) -> Point:
    """Point of the circle or ellipse at an angle (radians; the eccentric angle on ellipses)."""
    return conic.at_angle(angle)


def rotate(point: Point, center: Point, angle: float) -> Point:
    """Point turned counter-clockwise (radians) about a centre."""
    x, y = subtract(point, center)
    c, s = cos(angle), sin(angle)
    return center[0] + c * x - s * y, center[1] + s * x + c * y


def mirror(point: Point, line: Line) -> Point:
    """Mirror image of a point about a line."""
    d = unit(subtract(line.p2, line.p1))
    w = subtract(point, line.p1)
    twice = 2.0 * cross(d, w)
    n = left(d)
    return point[0] - twice * n[0], point[1] - twice * n[1]


def scale(point: Point, center: Point, factor: float) -> Point:
    """Point moved away from a centre by a factor."""
    return center[0] + factor * (point[0] - center[0]), center[1] + factor * (point[1] - center[1])


def shift(point: Point, by: Point) -> Point:
    """Point moved by a vector."""
    return point[0] + by[0], point[1] + by[1]


def tangent(curve: Curve, t: float = 0.0) -> Point:
    """Unit vector of travel; of a line from p1 to p2."""
    return curve.tangent_at(t)


def normal(curve: Curve, t: float = 0.0) -> Point:
    """Unit vector to the left of the direction of travel."""
    return curve.normal_at(t)


def distance(a: Point, b: Point | Curve) -> float:
    """Distance of two points, or of a point from a line (its carrier) or another curve.

    The distance from a circle, an ellipse or an arc is that from its carrier.
    """
    if isinstance(b, Curve):
        return b.nearest(a, carrier=True).distance
    return gap(a, b)


def towards(point: Point, target: Point, length: float) -> Point:
    """Point at a distance from `point` in the direction of `target`."""
    d = times(unit(subtract(target, point)), length)
    return point[0] + d[0], point[1] + d[1]
