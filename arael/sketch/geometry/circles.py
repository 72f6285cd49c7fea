"""Circles through points and tangent to lines."""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

from arael.sketch.geometry.circular import Circle
from arael.sketch.geometry.line import Line
from arael.sketch.geometry.vectors import Point, cross, dot, left, norm, subtract


class TangentCircle(NamedTuple):
    """A circle tangent to lines: the points of contact, and whether all lie on the segments."""

    circle: Circle
    contacts: tuple[Point, ...]
    on_segments: bool


def circle_through(p: Point, q: Point, r: Point) -> Circle | None:
    """Circle through three points; None if they are on one line (or two of them coincide)."""
    a, b = subtract(q, p), subtract(r, p)
    double = 2.0 * cross(a, b)
    aa, bb = dot(a, a), dot(b, b)
    if not abs(double) > 1e-14 * max(aa, bb):
        return None
    w = ((aa * b[1] - bb * a[1]) / double, (bb * a[0] - aa * b[0]) / double)
    return Circle((p[0] + w[0], p[1] + w[1]), norm(w))


def circles_tangent_to_two(a: Line, b: Line, radius: float) -> list[TangentCircle]:
    """The four circles of a radius tangent to two lines; none if the lines are parallel."""
    found = []
    d, e = a.tangent_at(0.0), b.tangent_at(0.0)
    sine = cross(d, e)
    if abs(sine) < 1e-12:
        return []
    w = subtract(b.p1, a.p1)
    for s, t in product((1.0, -1.0), repeat=2):
        # signed distances s r and t r from the two lines: cross(d, x) = s r, cross(e, x) = t r + k
        f, g = s * radius, t * radius + cross(e, w)
        center = (f * e[0] - g * d[0]) / sine, (f * e[1] - g * d[1]) / sine
        center = a.p1[0] + center[0], a.p1[1] + center[1]
        found.append(_tangent(Circle(center, radius), (a, b)))
    return found


def circles_tangent_to_three(a: Line, b: Line, c: Line) -> list[TangentCircle]:
    """Circles tangent to three lines: up to four, two if two of the lines are parallel."""
    lines = (a, b, c)
    origin = a.p1
    normals = [left(line.tangent_at(0.0)) for line in lines]
    offsets = [dot(n, subtract(line.p1, origin)) for n, line in zip(normals, lines, strict=True)]
    found: list[TangentCircle] = []
    size = max(line.length() for line in lines)
    for s, t in product((1.0, -1.0), repeat=2):
        # n_i . x - s_i r = k_i; the sign of r is free, so one of the signs is not
        rows = [(n[0], n[1], -sign) for n, sign in zip(normals, (1.0, s, t), strict=True)]
        solution = _solve3(rows, offsets)
        if solution is None:
            continue
        x, y, r = solution
        if abs(r) <= 1e-12 * size or abs(r) > 1e12 * size:
            continue
        found.append(_tangent(Circle((origin[0] + x, origin[1] + y), abs(r)), lines))
    return found


def _tangent(circle: Circle, lines: tuple[Line, ...]) -> TangentCircle:
    contacts, inside = [], True
    for line in lines:
        t = line.nearest(circle.center, carrier=True).t
        contacts.append(line.point_at(t))
        inside = inside and -1e-9 <= t <= 1.0 + 1e-9
    return TangentCircle(circle, tuple(contacts), inside)


def _solve3(
    rows: list[tuple[float, float, float]], right: list[float]
) -> tuple[float, float, float] | None:
    """Cramer's rule; None if the determinant vanishes (rows are of unit size)."""
    (a, b, c), (d, e, f), (g, h, i) = rows
    det = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    if abs(det) < 1e-12:
        return None
    u, v, w = right
    x = u * (e * i - f * h) - b * (v * i - f * w) + c * (v * h - e * w)
    y = a * (v * i - f * w) - u * (d * i - f * g) + c * (d * w - v * g)
    z = a * (e * w - v * h) - b * (d * w - v * g) + u * (d * h - e * g)
    return x / det, y / det, z / det
