"""Straight lines."""

from __future__ import annotations

from math import hypot

from arael.sketch.geometry.affine import Affine
from arael.sketch.geometry.curve import Bounds, Curve, Nearest
from arael.sketch.geometry.vectors import Point, between, cross, subtract


class Line(Curve, frozen=True):
    """Segment from `p1` to `p2`; its carrier is the whole line."""

    p1: Point
    p2: Point

    def point_at(self, t: float) -> Point:
        """Point at the fraction `t` of the length; exact at both ends."""
        return between(self.p1, self.p2, t)

    def derivative_at(self, t: float) -> Point:
        """Vector from `p1` to `p2`."""
        return subtract(self.p2, self.p1)

    def second_at(self, t: float) -> Point:
        """Zero."""
        return 0.0, 0.0

    def length(self) -> float:
        """Distance of the ends."""
        return hypot(self.p2[0] - self.p1[0], self.p2[1] - self.p1[1])

    def nearest(self, point: Point, *, carrier: bool = False) -> Nearest:
        """Foot of the perpendicular, or the nearer end."""
        (x1, y1), (x2, y2) = self.p1, self.p2
        dx, dy = x2 - x1, y2 - y1
        # scaled by the larger component: no overflow, no underflow at any size
        scale = max(abs(dx), abs(dy))
        if not scale > 0.0:
            return Nearest(0.0, hypot(point[0] - x1, point[1] - y1))
        ux, uy = dx / scale, dy / scale
        t = ((point[0] - x1) / scale * ux + (point[1] - y1) / scale * uy) / (ux * ux + uy * uy)
        if not carrier:
            t = min(max(t, 0.0), 1.0)
        foot = self.point_at(t)
        return Nearest(t, hypot(point[0] - foot[0], point[1] - foot[1]))

    def signed_distance(self, point: Point) -> float:
        """Distance from the carrier, positive to the left of the direction from `p1` to `p2`."""
        d = self.tangent_at(0.0)
        return cross(d, subtract(point, self.p1))

    def bounds(self) -> Bounds:
        """Rectangle of the two ends."""
        (x1, y1), (x2, y2) = self.p1, self.p2
        return Bounds(min(x1, x2), min(y1, y2), max(x1, x2), max(y1, y2))

    def sample(self, tolerance: float) -> list[Point]:
        """Both ends."""
        return [self.p1, self.p2]

    def part(self, start: float, end: float) -> Line:
        """Segment between two fractions."""
        return Line(self.point_at(start), self.point_at(end))

    def reversed(self) -> Line:
        """From `p2` to `p1`."""
        return Line(self.p2, self.p1)

    def transformed(self, by: Affine) -> Line:
        """Segment of the images of the ends."""
        return Line(by(self.p1), by(self.p2))

    def area_about(self, origin: Point) -> float:
        """Triangle of the origin and the ends."""
        return 0.5 * cross(subtract(self.p1, origin), subtract(self.p2, origin))
