"""Ellipses and their arcs."""

from __future__ import annotations

from math import atan2

from arael.sketch.geometry.affine import Affine
from arael.sketch.geometry.conic import Conic, PartOfConic, axes_under
from arael.sketch.geometry.vectors import TURN, Point, sweep_between


class _Elliptic(Conic, frozen=True):
    """Centre, two radii and a rotation (radians)."""

    center: Point
    rx: float
    ry: float
    rotation: float

    @property
    def middle(self) -> Point:
        """Centre."""
        return self.center

    @property
    def radii(self) -> Point:
        """Radii along the turned x and y axes."""
        return self.rx, self.ry

    @property
    def turned(self) -> float:
        """Rotation."""
        return self.rotation

    def eccentric_angle(self, point: Point) -> float:
        """Eccentric angle of the point of the ellipse in whose affine direction `point` lies."""
        x, y = self.local(point)
        return atan2(y * self.rx, x * self.ry)


class Ellipse(_Elliptic, frozen=True):
    """A whole ellipse: radii `rx`, `ry` along axes turned by `rotation` (radians)."""

    rotation: float = 0.0

    def part(self, start: float, end: float) -> EllipticArc:
        """Arc between two parameters; at most one turn."""
        return EllipticArc(
            self.center, self.rx, self.ry, self.rotation, start * TURN, (end - start) * TURN
        )

    def reversed(self) -> EllipticArc:
        """The full turn clockwise, as an arc."""
        return EllipticArc(self.center, self.rx, self.ry, self.rotation, 0.0, -TURN)

    def transformed(self, by: Affine) -> Ellipse:
        """Image under an affine map."""
        (rx, ry), rotation, _, _ = axes_under(by, self.radii, self.rotation)
        return Ellipse(by(self.center), rx, ry, rotation)


class EllipticArc(PartOfConic, _Elliptic, frozen=True):
    """Arc of an ellipse from the eccentric angle `angle` through `sweep` (radians, nonzero)."""

    angle: float
    sweep: float

    @classmethod
    def between(
        cls, center: Point, start: Point, end: Point, rx: float, ry: float, rotation: float
    ) -> EllipticArc:
        """Counter-clockwise arc between two points; equal points make a full turn."""
        whole = Ellipse(center, rx, ry, rotation)
        a = whole.eccentric_angle(start)
        return cls(center, rx, ry, rotation, a, sweep_between(a, whole.eccentric_angle(end)))

    @property
    def carrier(self) -> Ellipse:
        """The whole ellipse."""
        return Ellipse(self.center, self.rx, self.ry, self.rotation)

    def part(self, start: float, end: float) -> EllipticArc:
        """Arc between two parameters."""
        angle, sweep = self.angle_at(start), (end - start) * self.sweep
        return EllipticArc(self.center, self.rx, self.ry, self.rotation, angle, sweep)

    def transformed(self, by: Affine) -> EllipticArc:
        """Image under an affine map; mirrors turn the sweep round."""
        (rx, ry), rotation, shift, sign = axes_under(by, self.radii, self.rotation)
        angle = sign * (self.angle + shift)
        return EllipticArc(by(self.center), rx, ry, rotation, angle, sign * self.sweep)
