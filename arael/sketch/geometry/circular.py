"""Circles and their arcs."""

from __future__ import annotations

from math import cos, sin

from arael.sketch.geometry.affine import Affine
from arael.sketch.geometry.conic import Conic, PartOfConic, axes_under
from arael.sketch.geometry.elliptic import Ellipse, EllipticArc
from arael.sketch.geometry.vectors import (
    TURN,
    Point,
    direction_angle,
    gap,
    subtract,
    sweep_between,
)


class _Circular(Conic, frozen=True):
    """Centre and radius."""

    center: Point
    radius: float

    @property
    def middle(self) -> Point:
        """Centre."""
        return self.center

    @property
    def radii(self) -> Point:
        """The radius, twice."""
        return self.radius, self.radius

    def at_angle(self, angle: float) -> Point:
        """Point of the circle at a polar angle."""
        x, y = self.center
        return x + self.radius * cos(angle), y + self.radius * sin(angle)


class Circle(_Circular, frozen=True):
    """A whole circle; `t` runs counter-clockwise from the direction of the x axis."""

    def part(self, start: float, end: float) -> Arc:
        """Arc between two parameters; at most one turn."""
        return Arc(self.center, self.radius, start * TURN, (end - start) * TURN)

    def reversed(self) -> Arc:
        """The full turn clockwise, as an arc."""
        return Arc(self.center, self.radius, 0.0, -TURN)

    def transformed(self, by: Affine) -> Circle | Ellipse:
        """Circle if the map keeps shapes, otherwise an ellipse."""
        factor = by.factor
        if factor is not None:
            return Circle(by(self.center), self.radius * factor)
        (rx, ry), rotation, _, _ = axes_under(by, self.radii, 0.0)
        return Ellipse(by(self.center), rx, ry, rotation)


class Arc(PartOfConic, _Circular, frozen=True):
    """Arc from the polar angle `angle` through `sweep` (radians, nonzero, at most a full turn).

    Documents hold arcs that run counter-clockwise, 0 < sweep <= 2 pi. A negative sweep is the same
    arc travelled clockwise, as in a chain or after `reversed`.
    """

    angle: float
    sweep: float

    @classmethod
    def between(cls, center: Point, start: Point, end: Point, radius: float | None = None) -> Arc:
        """Counter-clockwise arc between the directions of two points from the centre.

        `radius` is the distance of the start unless given. Equal directions make a full turn.
        """
        a = direction_angle(subtract(start, center))
        b = direction_angle(subtract(end, center))
        r = gap(start, center) if radius is None else radius
        return cls(center, r, a, sweep_between(a, b))

    @property
    def carrier(self) -> Circle:
        """The whole circle."""
        return Circle(self.center, self.radius)

    def part(self, start: float, end: float) -> Arc:
        """Arc between two parameters."""
        return Arc(self.center, self.radius, self.angle_at(start), (end - start) * self.sweep)

    def transformed(self, by: Affine) -> Arc | EllipticArc:
        """Arc if the map keeps shapes, otherwise an elliptic arc; mirrors turn the sweep round."""
        (rx, ry), rotation, shift, sign = axes_under(by, self.radii, 0.0)
        angle = sign * (self.angle + shift)
        if by.factor is not None:
            return Arc(by(self.center), rx, rotation + angle, sign * self.sweep)
        return EllipticArc(by(self.center), rx, ry, rotation, angle, sign * self.sweep)
