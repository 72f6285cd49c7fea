"""An implicit curve along a polynomial one: all roots of one polynomial on [0, 1].

Besides the roots, the extremes are tried: where two curves touch without quite crossing, the
polynomial has no root, but an extreme beside zero.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import atan, cos, pi, sin

from arael.sketch.geometry import bernstein
from arael.sketch.geometry.conic import Conic
from arael.sketch.geometry.contacts.contact import Candidate
from arael.sketch.geometry.curve import Curve
from arael.sketch.geometry.line import Line
from arael.sketch.geometry.splines import Bezier
from arael.sketch.geometry.vectors import Point, cross, subtract


def beziers_parameters(other: Line | Conic, curve: Bezier) -> list[float]:
    """Parameters of a Bezier curve where it may meet a line or a conic."""
    if isinstance(other, Line):
        d = other.derivative_at(0.0)
        return _zeros([cross(d, subtract(p, other.p1)) for p in curve.poles])
    rx, ry = other.radii
    local = [other.local(p) for p in curve.poles]
    xs, ys = [p[0] / rx for p in local], [p[1] / ry for p in local]
    square = zip(bernstein.product(xs, xs), bernstein.product(ys, ys), strict=True)
    return _zeros([x + y - 1.0 for x, y in square])


def conics_angles(other: Conic, conic: Conic) -> Iterator[float]:
    """Angles of `conic` where it may meet another.

    Each quarter is a rational curve of degree 2: cosine and sine are (1 - t^2, 2 t) / (1 + t^2).
    """
    rx, ry = other.radii
    center = _scaled(other.local(conic.middle), rx, ry)
    right = _scaled(subtract(other.local(conic.at_angle(0.0)), other.local(conic.middle)), rx, ry)
    up = _scaled(subtract(other.local(conic.at_angle(0.5 * pi)), other.local(conic.middle)), rx, ry)
    for quarter in range(4):
        c, s = round(cos(quarter * pi / 2)), round(sin(quarter * pi / 2))
        a = c * right[0] + s * up[0], c * right[1] + s * up[1]
        b = c * up[0] - s * right[0], c * up[1] - s * right[1]
        weights = (1.0, 1.0, 2.0)
        x, y = (
            [w * center[i] + p * a[i] + q * b[i]
             for w, p, q in zip(weights, (1.0, 1.0, 0.0), (0.0, 1.0, 2.0), strict=True)]
            for i in (0, 1)
        )  # fmt: skip
        products = zip(
            bernstein.product(x, x),
            bernstein.product(y, y),
            bernstein.product(weights, weights),
            strict=True,
        )
        for t in _zeros([p + q - w for p, q, w in products]):
            yield 2.0 * atan(t) + quarter * pi / 2


def candidates(curve: Curve, ts: list[float], other: Curve) -> list[Candidate]:
    """Pairs of parameters from those of `curve`, by the feet on `other`."""
    return [Candidate(t, other.nearest(curve.point_at(t), carrier=True).t) for t in ts]


def _scaled(p: Point, rx: float, ry: float) -> Point:
    return p[0] / rx, p[1] / ry


def _zeros(f: list[float]) -> list[float]:
    return bernstein.roots(f) + bernstein.roots(bernstein.derivative(f))
