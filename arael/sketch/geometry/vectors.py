"""Points and directions of the plane as pairs of floats.

Tuples, not arrays: one call handles two numbers, and NumPy would spend microseconds on them.
"""

from __future__ import annotations

from math import atan2, cos, hypot, pi, sin
from typing import TypeAlias

Point: TypeAlias = tuple[float, float]
"""A point or a direction: x and y."""

TURN = 2.0 * pi


class DegenerateError(ValueError):
    """Raised where geometry has collapsed: a line without length has no direction."""


def add(a: Point, b: Point) -> Point:
    """Sum of two vectors."""
    return a[0] + b[0], a[1] + b[1]


def subtract(a: Point, b: Point) -> Point:
    """Vector from `b` to `a`."""
    return a[0] - b[0], a[1] - b[1]


def times(a: Point, factor: float) -> Point:
    """Vector scaled by a factor."""
    return a[0] * factor, a[1] * factor


def dot(a: Point, b: Point) -> float:
    """Inner product."""
    return a[0] * b[0] + a[1] * b[1]


def cross(a: Point, b: Point) -> float:
    """Signed area of the parallelogram: positive if `b` is to the left of `a`."""
    return a[0] * b[1] - a[1] * b[0]


def left(a: Point) -> Point:
    """The vector turned by a quarter, counter-clockwise."""
    return -a[1], a[0]


def norm(a: Point) -> float:
    """Length of a vector."""
    return hypot(a[0], a[1])


def gap(a: Point, b: Point) -> float:
    """Distance of two points."""
    return hypot(a[0] - b[0], a[1] - b[1])


def between(a: Point, b: Point, fraction: float = 0.5) -> Point:
    """Point at `fraction` of the way from `a` to `b`; exact at both ends."""
    rest = 1.0 - fraction
    return rest * a[0] + fraction * b[0], rest * a[1] + fraction * b[1]


def unit(a: Point) -> Point:
    """Direction of a vector; raises `DegenerateError` for the zero vector."""
    length = hypot(a[0], a[1])
    if not length > 0.0:
        raise DegenerateError("a vector of length 0 has no direction")
    return a[0] / length, a[1] / length


def polar(angle: float, length: float = 1.0) -> Point:
    """Vector of the given direction (radians, from the x axis) and length."""
    return length * cos(angle), length * sin(angle)


def direction_angle(a: Point) -> float:
    """Angle of a vector with the x axis, in (-pi, pi]."""
    return atan2(a[1], a[0])


def positive_angle(angle: float) -> float:
    """The angle in [0, 2 pi)."""
    found = angle % TURN
    return 0.0 if found >= TURN else found


def signed_angle(angle: float) -> float:
    """The angle in (-pi, pi]."""
    found = positive_angle(angle)
    return found - TURN if found > pi else found


def sweep_between(start: float, end: float) -> float:
    """Counter-clockwise angle from `start` to `end` in (0, 2 pi]: equal angles are a full turn."""
    return positive_angle(end - start) or TURN
