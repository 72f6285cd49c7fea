"""Angles between directions, and which of the four sectors of two lines a dimension means."""

from __future__ import annotations

from math import atan2, copysign, pi
from typing import Literal, TypeAlias

from arael.sketch.geometry.line import Line
from arael.sketch.geometry.vectors import Point, cross, dot, signed_angle, subtract

Sector: TypeAlias = Literal["default", "supplement", "closest", "acute", "obtuse"]


def angle(a: Point, b: Point) -> float:
    """Signed angle from one direction to another, in (-pi, pi]; counter-clockwise is positive.

    By both products, so that it is accurate also near 0 and pi.
    """
    return atan2(cross(a, b), dot(a, b))


def angle_between(a: Line, b: Line) -> float:
    """Signed angle from the direction of one line (p1 to p2) to that of another."""
    return angle(subtract(a.p2, a.p1), subtract(b.p2, b.p1))


def line_angle(line: Line) -> float:
    """Angle of a line with the x axis, in (-pi, pi]."""
    x, y = subtract(line.p2, line.p1)
    return atan2(y, x)


def sector_angle(found: float, sector: Sector = "default", near: float = 0.0) -> float:
    """Angle of a sector of two lines, from the signed angle of their directions.

    ``default`` is the angle itself; ``supplement`` that with the second line reversed; ``acute``
    and ``obtuse`` are unsigned and at most, or at least, a right angle; ``closest`` is that of the
    angle and its supplement, with either sign, which is nearest to `near`.
    """
    other = found - copysign(pi, found)
    if sector == "supplement":
        return signed_angle(other)
    if sector == "acute":
        return min(abs(found), pi - abs(found))
    if sector == "obtuse":
        return max(abs(found), pi - abs(found))
    if sector == "closest":
        return min((found, other, -found, -other), key=lambda a: abs(signed_angle(a - near)))
    return found
