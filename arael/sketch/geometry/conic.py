"""What circles, arcs, ellipses and elliptic arcs share.

Each is the image of (cos angle, sin angle) in a frame of centre, two radii and a rotation. `angle`
is the polar angle from the rotated x axis on circles, and the eccentric angle on ellipses.
"""

from __future__ import annotations

from math import acos, atan2, ceil, cos, hypot, pi, sin
from typing import TYPE_CHECKING, Self

from msgspec.structs import replace

from arael.sketch.geometry.affine import Affine
from arael.sketch.geometry.curve import MOST_SAMPLES, Bounds, Curve, Nearest, bounds_of
from arael.sketch.geometry.feet import ellipse_feet
from arael.sketch.geometry.vectors import (
    TURN,
    Point,
    cross,
    positive_angle,
    signed_angle,
    subtract,
)


class Conic(Curve, frozen=True):
    """A circle or ellipse, or a part of one."""

    @property
    def middle(self) -> Point:
        """Centre."""
        raise NotImplementedError

    @property
    def radii(self) -> Point:
        """Radii along the rotated x and y axes."""
        raise NotImplementedError

    @property
    def turned(self) -> float:
        """Rotation of the frame, radians."""
        return 0.0

    @property
    def span(self) -> Point:
        """Angle of the start, and the signed sweep: positive is counter-clockwise."""
        return 0.0, TURN

    @property
    def closed(self) -> bool:
        """Whether this is a whole circle or ellipse."""
        return True

    def angle_at(self, t: float) -> float:
        """Angle at a parameter."""
        angle, sweep = self.span
        return angle + t * sweep

    def parameter(self, angle: float, *, clamp: bool = False) -> float:
        """Parameter of an angle; off an arc below 0 or above 1, whichever end is nearer.

        With `clamp`, the parameter of that end.
        """
        start, sweep = self.span
        if self.closed:
            return positive_angle(angle - start) / TURN
        t = 0.5 + signed_angle(angle - start - 0.5 * sweep) / sweep
        return min(max(t, 0.0), 1.0) if clamp else t

    def at_angle(self, angle: float) -> Point:
        """Point of the carrier at an angle."""
        return self._place(cos(angle), sin(angle))

    def local(self, point: Point) -> Point:
        """Coordinates of a point in the frame of centre and axes, not divided by the radii."""
        x, y = subtract(point, self.middle)
        turned = self.turned
        if turned == 0.0:
            return x, y
        c, s = cos(turned), sin(turned)
        return c * x + s * y, c * y - s * x

    def _place(self, x: float, y: float) -> Point:
        """Point of the plane from coordinates in units of the radii."""
        dx, dy = self._vector(x, y)
        cx, cy = self.middle
        return cx + dx, cy + dy

    def _vector(self, x: float, y: float) -> Point:
        rx, ry = self.radii
        x, y, turned = rx * x, ry * y, self.turned
        if turned == 0.0:
            return x, y
        c, s = cos(turned), sin(turned)
        return c * x - s * y, s * x + c * y

    def point_at(self, t: float) -> Point:
        """Point at `t`, also beyond the ends of an arc."""
        return self.at_angle(self.angle_at(t))

    def derivative_at(self, t: float) -> Point:
        """Derivative by `t`."""
        start, sweep = self.span
        angle = start + t * sweep
        return self._vector(-sin(angle) * sweep, cos(angle) * sweep)

    def second_at(self, t: float) -> Point:
        """Second derivative by `t`."""
        start, sweep = self.span
        angle = start + t * sweep
        return self._vector(-cos(angle) * sweep * sweep, -sin(angle) * sweep * sweep)

    def length(self) -> float:
        """Length of the arc: by elliptic integrals of the second kind where radii differ."""
        rx, ry = self.radii
        start, sweep = self.span
        if rx == ry:
            return rx * abs(sweep)
        # imported here: start-up time
        from scipy.special import ellipeinc

        # ds = a sqrt(1 - m cos^2) and b sqrt(1 - m sin^2): the longer radius in front
        big, small = max(rx, ry), min(rx, ry)
        m = 1.0 - (small / big) ** 2
        quarter = 0.5 * pi if rx > ry else 0.0
        ends = ellipeinc([start + sweep + quarter, start + quarter], m)
        return float(big * abs(ends[0] - ends[1]))

    def nearest(self, point: Point, *, carrier: bool = False) -> Nearest:
        """Nearest point; of several (the centre of a circle) one of them."""
        rx, ry = self.radii
        x, y = self.local(point)
        if rx == ry:
            t = self.parameter(atan2(y, x), clamp=not carrier)
            return self._foot(t, point)
        feet = ellipse_feet(x, y, rx, ry)
        if carrier or self.closed:
            return self._foot(self.parameter(feet[0]), point)
        ts = [t for t in map(self.parameter, feet) if 0.0 <= t <= 1.0]
        return min((self._foot(t, point) for t in (*ts, 0.0, 1.0)), key=lambda foot: foot.distance)

    def _foot(self, t: float, point: Point) -> Nearest:
        x, y = self.point_at(t)
        return Nearest(t, hypot(point[0] - x, point[1] - y))

    def bounds(self) -> Bounds:
        """Rectangle of the ends and of the extremes that lie on the arc."""
        cx, cy = self.middle
        rx, ry = self.radii
        c, s = cos(self.turned), sin(self.turned)
        if self.closed:
            hx, hy = hypot(rx * c, ry * s), hypot(rx * s, ry * c)
            return Bounds(cx - hx, cy - hy, cx + hx, cy + hy)
        across, up = atan2(-ry * s, rx * c), atan2(ry * c, rx * s)
        points = [self.start, self.end]
        for angle in (across, across + pi, up, up + pi):
            if 0.0 <= self.parameter(angle) <= 1.0:
                points.append(self.at_angle(angle))
        return bounds_of(points)

    def sample(self, tolerance: float) -> list[Point]:
        """Points at even angles; the step is that of the circle of the larger radius."""
        most = max(self.radii)
        step = 2.0 * acos(max(1.0 - tolerance / most, 0.0)) if most > tolerance else pi
        sweep = abs(self.span[1])
        count = min(MOST_SAMPLES, max(ceil(sweep / max(step, 1e-9)), 3 if sweep > 4 else 1))
        return [self.point_at(i / count) for i in range(count + 1)]

    def area_about(self, origin: Point) -> float:
        """Sector of the ellipse and the triangle of its centre."""
        rx, ry = self.radii
        sweep = self.span[1]
        chord = subtract(self.end, self.start) if not self.closed else (0.0, 0.0)
        return 0.5 * (rx * ry * sweep + cross(subtract(self.middle, origin), chord))


class PartOfConic(Conic, frozen=True):
    """An arc: a conic from an angle through a sweep, which its kinds hold as `angle`, `sweep`."""

    if TYPE_CHECKING:  # fields of two bases cannot be combined
        angle: float
        sweep: float

    @property
    def span(self) -> Point:
        """Angle of the start and signed sweep."""
        return self.angle, self.sweep

    @property
    def closed(self) -> bool:
        """False: also a full turn has a start."""
        return False

    def reversed(self) -> Self:
        """The same arc travelled the other way."""
        return replace(self, angle=self.angle + self.sweep, sweep=-self.sweep)

    def forward(self) -> Self:
        """The arc counter-clockwise."""
        return self if self.sweep > 0 else self.reversed()


def axes_under(by: Affine, radii: Point, turned: float) -> tuple[Point, float, float, float]:
    """Radii, rotation, shift of the angle and its sign, of an ellipse under a linear map.

    The singular value decomposition of the image of the axes, in closed form (Blinn: Consider the
    lowly 2x2 matrix, 1996). A point of angle ``a`` has the angle ``sign * (a + shift)`` afterwards.
    """
    rx, ry = radii
    sign = 1.0 if by.determinant >= 0.0 else -1.0
    c, s = cos(turned), sin(turned)
    p, r = by.direction((rx * c, rx * s))
    factor = by.factor
    if factor is not None:
        return (rx * factor, ry * factor), atan2(r, p), 0.0, sign
    q, w = by.direction((-ry * s, ry * c))
    e, f, g, h = 0.5 * (p + w), 0.5 * (p - w), 0.5 * (r + q), 0.5 * (r - q)
    big, small = hypot(e, h) + hypot(f, g), hypot(e, h) - hypot(f, g)
    a1, a2 = atan2(g, f), atan2(h, e)
    return (big, abs(small)), 0.5 * (a2 + a1), 0.5 * (a2 - a1), sign
