"""What every curve can answer; each kind adds its own formulas.

A curve is a frozen value. Its parameter `t` runs from 0 to 1: evenly in length on lines and
circles, evenly in the eccentric angle on ellipses, and as the polynomial's own on splines.
"""

from __future__ import annotations

from itertools import pairwise
from math import hypot
from typing import NamedTuple, Self

import msgspec

from arael.sketch.geometry.affine import Affine
from arael.sketch.geometry.vectors import Point, add, cross, left, times, unit

MOST_SAMPLES = 20_000
"""Points of one sampled curve at most, however small the tolerance."""


class Nearest(NamedTuple):
    """Foot of a point on a curve: its parameter, and its distance from the point."""

    t: float
    distance: float


class Piece(NamedTuple):
    """Part of a curve that was cut, and the parameters of the whole where it starts and ends."""

    curve: Curve
    start: float
    end: float


class Bounds(NamedTuple):
    """Axis-parallel rectangle."""

    x_min: float
    y_min: float
    x_max: float
    y_max: float

    @property
    def size(self) -> float:
        """Length of the diagonal."""
        return hypot(self.x_max - self.x_min, self.y_max - self.y_min)

    def union(self, other: Bounds) -> Bounds:
        """Smallest rectangle around both."""
        return Bounds(
            min(self.x_min, other.x_min),
            min(self.y_min, other.y_min),
            max(self.x_max, other.x_max),
            max(self.y_max, other.y_max),
        )

    def apart(self, other: Bounds, tolerance: float = 0.0) -> bool:
        """Whether the rectangles are further apart than `tolerance` in x or in y."""
        return (
            self.x_min > other.x_max + tolerance
            or other.x_min > self.x_max + tolerance
            or self.y_min > other.y_max + tolerance
            or other.y_min > self.y_max + tolerance
        )


def bounds_of(points: list[Point] | tuple[Point, ...]) -> Bounds:
    """Rectangle around at least one point."""
    xs = [p[0] for p in points]
    ys = [p[1] for p in points]
    return Bounds(min(xs), min(ys), max(xs), max(ys))


class Curve(msgspec.Struct, frozen=True):
    """A curve of the plane."""

    @property
    def closed(self) -> bool:
        """Whether the curve is a whole circle or ellipse: `t` is then taken modulo 1."""
        return False

    def point_at(self, t: float) -> Point:
        """Point at `t`; beyond 0 and 1 on the carrier."""
        raise NotImplementedError

    def derivative_at(self, t: float) -> Point:
        """First derivative by `t`."""
        raise NotImplementedError

    def second_at(self, t: float) -> Point:
        """Second derivative by `t`."""
        raise NotImplementedError

    def length(self) -> float:
        """Length from t = 0 to t = 1."""
        raise NotImplementedError

    def nearest(self, point: Point, *, carrier: bool = False) -> Nearest:
        """Foot of `point` on the curve, or on its whole carrier (line, circle, ellipse)."""
        raise NotImplementedError

    def bounds(self) -> Bounds:
        """Smallest axis-parallel rectangle around the curve."""
        raise NotImplementedError

    def sample(self, tolerance: float) -> list[Point]:
        """Points from start to end whose polyline stays within `tolerance` of the curve."""
        raise NotImplementedError

    def part(self, start: float, end: float) -> Curve:
        """The curve from `start` to `end`, start < end; see `split` for B-splines."""
        raise NotImplementedError

    def reversed(self) -> Curve:
        """The same points in the other direction."""
        raise NotImplementedError

    def transformed(self, by: Affine) -> Curve:
        """Image under an affine map; a circle becomes an ellipse unless shapes are kept."""
        raise NotImplementedError

    def area_about(self, origin: Point) -> float:
        """Signed area swept by the ray from `origin` along the curve (Green's theorem)."""
        raise NotImplementedError

    @property
    def start(self) -> Point:
        """Point at t = 0."""
        return self.point_at(0.0)

    @property
    def end(self) -> Point:
        """Point at t = 1."""
        return self.point_at(1.0)

    def tangent_at(self, t: float) -> Point:
        """Unit vector of the direction of travel; raises `DegenerateError` at a cusp."""
        return unit(self.derivative_at(t))

    def normal_at(self, t: float) -> Point:
        """Unit vector to the left of the direction of travel."""
        return left(self.tangent_at(t))

    def curvature_at(self, t: float) -> float:
        """Signed curvature: positive where the curve turns to the left."""
        d = self.derivative_at(t)
        speed = hypot(d[0], d[1])
        return cross(d, self.second_at(t)) / speed**3

    def offset_point(self, t: float, distance: float) -> Point:
        """Point beside the curve at `t`, to the left for a positive distance."""
        return add(self.point_at(t), times(self.normal_at(t), distance))

    def split(self, *at: float) -> list[Piece]:
        """Cut at parameters: pieces from start to end; of a closed curve from the first cut on.

        Cuts at the ends of an open curve, and repeated ones, count once. A B-spline that is cut
        inside a span is also cut at the ends of that span, since the pieces keep uniform knots.
        """
        if self.closed:
            cuts = sorted({t % 1.0 for t in at})
            if not cuts:
                return [Piece(self, 0.0, 1.0)]
            ends = [*cuts[1:], cuts[0] + 1.0]
            return [Piece(self.part(a, b), a, b) for a, b in zip(cuts, ends, strict=True)]
        cuts = [0.0, *sorted({t for t in at if 0.0 < t < 1.0}), 1.0]
        return [piece for a, b in pairwise(cuts) for piece in self._cut(a, b)]

    def _cut(self, start: float, end: float) -> list[Piece]:
        return [Piece(self.part(start, end), start, end)]

    def shifted(self, by: Point) -> Self:
        """The curve moved by a vector."""
        return self.transformed(Affine.shift(by))  # type: ignore[return-value]

    def rotated(self, angle: float, about: Point = (0.0, 0.0)) -> Self:
        """The curve turned counter-clockwise (radians) about a point."""
        return self.transformed(Affine.rotation(angle, about))  # type: ignore[return-value]

    def scaled(self, factor: float, about: Point = (0.0, 0.0)) -> Self:
        """The curve scaled about a point."""
        return self.transformed(Affine.scaling(factor, about))  # type: ignore[return-value]

    def mirrored(self, p1: Point, p2: Point) -> Self:
        """Mirror image about the line through two points; arcs run the other way round."""
        return self.transformed(Affine.mirror(p1, p2))  # type: ignore[return-value]
