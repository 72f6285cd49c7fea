"""Splines of DXF as cubic curves."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from arael.sketch.geometry import Bezier, BSpline, Curve, Point

_MOST_POLES = 20_000


def spline_curves(entity: Any) -> Iterator[Curve]:
    """A B-spline if it is cubic with uniform knots, otherwise cubic Bezier curves.

    Exact for polynomial splines of degree 3; rational ones and other degrees are approximated, to
    a few parts in a million of their size.
    """
    if max(entity.control_point_count(), entity.fit_point_count()) > _MOST_POLES:
        raise ValueError(f"a spline has more than {_MOST_POLES:,} poles")
    tool = entity.construction_tool()
    points = [_xy(p) for p in tool.control_points]
    if tool.degree == 3 and not tool.is_rational:
        if _is_uniform(list(tool.knots()), len(points)):
            if len(points) == 4:
                yield Bezier((points[0], points[1], points[2], points[3]))
            else:
                yield BSpline(tuple(points))
            return
        if tool.is_clamped:
            for poles in tool.bezier_decomposition():
                yield _bezier([_xy(p) for p in poles])
            return
    for piece in tool.cubic_bezier_approximation(level=8):
        yield _bezier([_xy(p) for p in piece.control_points])


def _is_uniform(knots: list[float], count: int) -> bool:
    """Whether knots are clamped at both ends, and even between."""
    if len(knots) != count + 4 or count < 4:
        return False
    first, last = knots[3], knots[-4]
    width = (last - first) / (count - 3)
    if not width > 0.0:
        return False
    expected = [first] * 3 + [first + i * width for i in range(count - 2)] + [last] * 3
    return all(abs(k - e) <= 1e-9 * (last - first) for k, e in zip(knots, expected, strict=True))


def _bezier(poles: list[Point]) -> Bezier:
    p, q, r, s = poles
    return Bezier((p, q, r, s))


def _xy(v: Any) -> Point:
    return float(v[0]), float(v[1])
