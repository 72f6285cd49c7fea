"""Curves as path commands."""

from __future__ import annotations

from math import ceil, tan

from arael.sketch.drawing.primitives import Segment
from arael.sketch.drawing.view import View
from arael.sketch.geometry import Bezier, BSpline, Conic, Curve, Line, Point
from arael.sketch.text import Stroke


def beziers_of(curve: Curve) -> list[tuple[Point, Point, Point, Point]]:
    """Cubic Bezier curves for a curve: exact for splines, to 1e-6 of the radius for conics.

    A conic is cut into parts of at most an eighth of a turn; the inner poles are at
    4/3 tan(sweep / 4) along the tangents.
    """
    if isinstance(curve, Bezier):
        return [curve.poles]
    if isinstance(curve, BSpline):
        return [piece.poles for piece in curve.beziers()]
    assert isinstance(curve, Conic)
    _, sweep = curve.span
    count = max(1, ceil(abs(sweep) / 0.7854))
    k = 4.0 / 3.0 * tan(0.25 * sweep / count) / sweep
    found = []
    for i in range(count):
        t, u = i / count, (i + 1) / count
        (ax, ay), (bx, by) = curve.point_at(t), curve.point_at(u)
        (dx, dy), (ex, ey) = curve.derivative_at(t), curve.derivative_at(u)
        found.append(((ax, ay), (ax + k * dx, ay + k * dy), (bx - k * ex, by - k * ey), (bx, by)))
    return found


def outline(curve: Curve, view: View) -> tuple[Segment, ...]:
    """Path of a curve in pixels."""
    if isinstance(curve, Line):
        return (("M", view(curve.p1)), ("L", view(curve.p2)))
    pieces = beziers_of(curve)
    found: list[Segment] = [("M", view(pieces[0][0]))]
    for _, q, r, s in pieces:
        found.append(("C", (*view(q), *view(r), *view(s))))
    if curve.closed:
        found.append(("Z", ()))
    return tuple(found)


def stroke_outline(stroke: Stroke, view: View) -> tuple[Segment, ...]:
    """Path in pixels of pieces that follow one another."""
    found: list[Segment] = []
    for piece in stroke:
        segments = outline(piece, view)
        found += segments[1:] if found else segments
    return tuple(found)
