"""Cubic Bezier curves and clamped cubic B-splines with uniform interior knots."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from math import ceil, hypot, sqrt

from arael.sketch.geometry import bernstein
from arael.sketch.geometry.affine import Affine
from arael.sketch.geometry.curve import (
    MOST_SAMPLES,
    Bounds,
    Curve,
    Nearest,
    Piece,
    bounds_of,
)
from arael.sketch.geometry.quadrature import integral
from arael.sketch.geometry.vectors import Point, between, cross, gap, subtract, times


class Bezier(Curve, frozen=True):
    """Cubic Bezier curve of four poles."""

    poles: tuple[Point, Point, Point, Point]

    @property
    def start(self) -> Point:
        """The first pole."""
        return self.poles[0]

    @property
    def end(self) -> Point:
        """The last pole."""
        return self.poles[3]

    def point_at(self, t: float) -> Point:
        """Point at `t`."""
        p, q, r, s = self.poles
        u = 1.0 - t
        a, b, c, d = u * u * u, 3 * u * u * t, 3 * u * t * t, t * t * t
        return (
            a * p[0] + b * q[0] + c * r[0] + d * s[0],
            a * p[1] + b * q[1] + c * r[1] + d * s[1],
        )

    def derivative_at(self, t: float) -> Point:
        """Derivative by `t`."""
        p, q, r, s = self.poles
        u = 1.0 - t
        a, b, c = 3 * u * u, 6 * u * t, 3 * t * t
        return (
            a * (q[0] - p[0]) + b * (r[0] - q[0]) + c * (s[0] - r[0]),
            a * (q[1] - p[1]) + b * (r[1] - q[1]) + c * (s[1] - r[1]),
        )

    def second_at(self, t: float) -> Point:
        """Second derivative by `t`."""
        p, q, r, s = self.poles
        u = 6.0 * (1.0 - t)
        t = 6.0 * t
        return (
            u * (p[0] - 2 * q[0] + r[0]) + t * (q[0] - 2 * r[0] + s[0]),
            u * (p[1] - 2 * q[1] + r[1]) + t * (q[1] - 2 * r[1] + s[1]),
        )

    def tangent_at(self, t: float) -> Point:
        """Direction of travel; where a pole is repeated, its limit."""
        if t == 0.0 or t == 1.0:
            p = self.poles if t == 0.0 else self.poles[::-1]
            for other in p[1:]:
                if other != p[0]:
                    d = gap(p[0], other) * (1.0 if t == 0.0 else -1.0)
                    return times(subtract(other, p[0]), 1.0 / d)
        return Curve.tangent_at(self, t)

    def length(self) -> float:
        """Length by adaptive Gauss-Legendre quadrature, to 1e-12 of itself."""
        return integral(lambda t: hypot(*self.derivative_at(t)))

    def nearest(self, point: Point, *, carrier: bool = False) -> Nearest:
        """Nearest point: of the roots of (B - p) . B', of degree 5, and the two ends."""
        x = [p[0] - point[0] for p in self.poles]
        y = [p[1] - point[1] for p in self.poles]
        f = bernstein.product(x, bernstein.derivative(x))
        g = bernstein.product(y, bernstein.derivative(y))
        found = bernstein.roots([a + b for a, b in zip(f, g, strict=True)])
        return min(
            (Nearest(t, gap(self.point_at(t), point)) for t in (0.0, 1.0, *found)),
            key=lambda foot: foot.distance,
        )

    def bounds(self) -> Bounds:
        """Rectangle of the ends and of the extremes in x and in y."""
        points = [self.poles[0], self.poles[3]]
        for axis in (0, 1):
            slope = bernstein.derivative([p[axis] for p in self.poles])
            points += [self.point_at(t) for t in bernstein.roots(slope)]
        return bounds_of(points)

    def sample(self, tolerance: float) -> list[Point]:
        """Points at even parameters (Filip, Magedson, Markot 1986: bound by second differences)."""
        p, q, r, s = self.poles
        bend = max(
            hypot(p[0] - 2 * q[0] + r[0], p[1] - 2 * q[1] + r[1]),
            hypot(q[0] - 2 * r[0] + s[0], q[1] - 2 * r[1] + s[1]),
        )
        count = max(1, ceil(min(sqrt(0.75 * bend / tolerance), MOST_SAMPLES)))
        return [self.point_at(i / count) for i in range(count + 1)]

    def part(self, start: float, end: float) -> Bezier:
        """Curve between two parameters."""
        xs, ys = (self._cut_axis(axis, start, end) for axis in (0, 1))
        poles = list(zip(xs, ys, strict=True))
        if start == 0.0:
            poles[0] = self.poles[0]
        if end == 1.0:
            poles[3] = self.poles[3]
        return Bezier((poles[0], poles[1], poles[2], poles[3]))

    def _cut_axis(self, axis: int, start: float, end: float) -> list[float]:
        row = [p[axis] for p in self.poles]
        first, _ = bernstein.halves(row, end)
        return bernstein.halves(first, start / end if end else 0.0)[1]

    def reversed(self) -> Bezier:
        """Poles in the other order."""
        p, q, r, s = self.poles
        return Bezier((s, r, q, p))

    def transformed(self, by: Affine) -> Bezier:
        """Curve of the images of the poles."""
        p, q, r, s = self.poles
        return Bezier((by(p), by(q), by(r), by(s)))

    def area_about(self, origin: Point) -> float:
        """Exact: the integral of a polynomial of degree 5."""
        p, q, r, s = (subtract(pole, origin) for pole in self.poles)
        return (
            6 * cross(p, q)
            + 3 * cross(p, r)
            + cross(p, s)
            + 3 * cross(q, r)
            + 3 * cross(q, s)
            + 6 * cross(r, s)
        ) / 20


class BSpline(Curve, frozen=True):
    """Cubic B-spline of at least four poles: ends at the first and last, knots evenly between.

    With n poles there are n - 3 spans, each of which is 1 / (n - 3) of the parameter.
    """

    poles: tuple[Point, ...]

    def __post_init__(self) -> None:
        if len(self.poles) < 4:
            raise ValueError(f"a cubic B-spline needs at least 4 poles, not {len(self.poles)}")

    @property
    def spans(self) -> int:
        """Number of polynomial spans."""
        return len(self.poles) - 3

    @property
    def start(self) -> Point:
        """The first pole."""
        return self.poles[0]

    @property
    def end(self) -> Point:
        """The last pole."""
        return self.poles[-1]

    def span_at(self, t: float) -> tuple[int, float]:
        """Number of the span, and the parameter within it."""
        u = t * self.spans
        k = min(max(int(u), 0), self.spans - 1)
        return k, u - k

    def bezier(self, k: int) -> Bezier:
        """Span `k` as a Bezier curve: the polar form at its knots (Ramshaw 1987)."""
        a, b = float(k), k + 1.0
        m = self.spans
        return Bezier(
            (
                _blossom(self.poles, m, k, a, a, a),
                _blossom(self.poles, m, k, a, a, b),
                _blossom(self.poles, m, k, a, b, b),
                _blossom(self.poles, m, k, b, b, b),
            )
        )

    def beziers(self) -> list[Bezier]:
        """All spans as Bezier curves."""
        return list(_spans(self))

    def point_at(self, t: float) -> Point:
        """Point at `t` (de Boor's scheme)."""
        m = self.spans
        u = t * m
        return _blossom(self.poles, m, min(max(int(u), 0), m - 1), u, u, u)

    def derivative_at(self, t: float) -> Point:
        """Derivative by `t`."""
        k, u = self.span_at(t)
        return times(self.bezier(k).derivative_at(u), self.spans)

    def second_at(self, t: float) -> Point:
        """Second derivative by `t`; at a knot that of the span that begins there."""
        k, u = self.span_at(t)
        return times(self.bezier(k).second_at(u), self.spans**2)

    def tangent_at(self, t: float) -> Point:
        """Direction of travel; where the first or last poles are repeated, its limit."""
        k, u = self.span_at(t)
        return self.bezier(k).tangent_at(u)

    def length(self) -> float:
        """Sum of the lengths of the spans."""
        return sum(piece.length() for piece in self.beziers())

    def nearest(self, point: Point, *, carrier: bool = False) -> Nearest:
        """Nearest point over all spans; those whose poles are too far away are skipped."""
        best = Nearest(0.0, gap(self.poles[0], point))
        for k, piece in enumerate(self.beziers()):
            box = bounds_of(piece.poles)
            dx = max(box.x_min - point[0], point[0] - box.x_max, 0.0)
            dy = max(box.y_min - point[1], point[1] - box.y_max, 0.0)
            if hypot(dx, dy) <= best.distance:
                foot = piece.nearest(point)
                if foot.distance < best.distance:
                    best = Nearest((k + foot.t) / self.spans, foot.distance)
        return best

    def bounds(self) -> Bounds:
        """Rectangle around the spans."""
        boxes = [piece.bounds() for piece in self.beziers()]
        found = boxes[0]
        for box in boxes[1:]:
            found = found.union(box)
        return found

    def sample(self, tolerance: float) -> list[Point]:
        """Points of the spans, the joints once."""
        points = [self.poles[0]]
        for piece in self.beziers():
            points += piece.sample(tolerance)[1:]
        return points

    def part(self, start: float, end: float) -> Bezier | BSpline:
        """Curve between two parameters that lie in one span, or are both at knots.

        Raises `ValueError` for others, which are no B-spline with uniform knots: see `split`.
        """
        pieces = self._cut(start, end)
        if len(pieces) > 1:
            raise ValueError("this part of the B-spline has no uniform knots: split it")
        found = pieces[0].curve
        assert isinstance(found, Bezier | BSpline)
        return found

    def _cut(self, start: float, end: float) -> list[Piece]:
        m = self.spans
        a, b = start * m, end * m
        first, last = ceil(a - 1e-12), int(b + 1e-12)  # whole spans between
        if first > last:
            return [self._within(first - 1, a, b)]
        pieces = []
        if first - a > 1e-12:
            pieces.append(self._within(first - 1, a, first))
        if last > first:
            pieces.append(Piece(self._whole(first, last), first / m, last / m))
        if b - last > 1e-12:
            pieces.append(self._within(last, last, b))
        return pieces

    def _within(self, k: int, a: float, b: float) -> Piece:
        return Piece(self.bezier(k).part(a - k, b - k), a / self.spans, b / self.spans)

    def _whole(self, first: int, last: int) -> Bezier | BSpline:
        """Spans first to last (exclusive): the poles are the polar form at the new knots."""
        if last - first == 1:
            return self.bezier(first)
        if first == 0 and last == self.spans:
            return self
        m, count = self.spans, last - first
        knots = [float(min(max(i, first), last)) for i in range(first - 2, last + 3)]
        poles = []
        for i in range(count + 3):
            u, v, w = knots[i : i + 3]
            k = min(max(first + i - 1, first), last - 1)
            poles.append(_blossom(self.poles, m, min(k, m - 1), u, v, w))
        return BSpline(tuple(poles))

    def reversed(self) -> BSpline:
        """Poles in the other order."""
        return BSpline(self.poles[::-1])

    def transformed(self, by: Affine) -> BSpline:
        """Curve of the images of the poles."""
        return BSpline(tuple(map(by, self.poles)))

    def area_about(self, origin: Point) -> float:
        """Sum over the spans."""
        return sum(piece.area_about(origin) for piece in self.beziers())


def poles_through(points: Sequence[Point]) -> tuple[Point, ...]:
    """Poles of the B-spline that is at a point at each of its knots, and straight at its ends.

    The natural cubic spline with uniform knots: C. de Boor, A Practical Guide to Splines, chapter
    IV.
    """
    # imported here: start-up time
    from scipy.interpolate import make_interp_spline

    found = make_interp_spline(range(len(points)), points, k=3, bc_type="natural").c
    return tuple((x, y) for x, y in found.tolist())


@lru_cache(maxsize=64)
def _spans(curve: BSpline) -> tuple[Bezier, ...]:
    """The spans of one curve, which intersections and feet ask for again and again."""
    return tuple(curve.bezier(k) for k in range(curve.spans))


def _knot(i: int, m: int) -> float:
    return float(min(max(i - 3, 0), m))


def _blossom(poles: tuple[Point, ...], m: int, k: int, u: float, v: float, w: float) -> Point:
    """Polar form of span `k` at three arguments, by de Boor's triangle."""
    row = list(poles[k : k + 4])
    for r, argument in ((1, u), (2, v), (3, w)):
        for i in range(3, r - 1, -1):
            low, high = _knot(k + i, m), _knot(k + i + 4 - r, m)
            row[i] = between(row[i - 1], row[i], (argument - low) / (high - low))
    return row[3]
