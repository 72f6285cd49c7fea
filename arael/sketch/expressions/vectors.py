"""Coordinates as values of expressions."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Vec:
    """A place or a direction in the plane."""

    x: float
    y: float

    def __add__(self, other: Vec) -> Vec:
        if not isinstance(other, Vec):
            return NotImplemented
        return Vec(self.x + other.x, self.y + other.y)

    def __sub__(self, other: Vec) -> Vec:
        if not isinstance(other, Vec):
            return NotImplemented
        return Vec(self.x - other.x, self.y - other.y)

    def __mul__(self, other: float | Vec) -> Vec:
        if isinstance(other, Vec):
            return NotImplemented
        return Vec(self.x * other, self.y * other)

    __rmul__ = __mul__

    def __truediv__(self, other: float | Vec) -> Vec:
        if isinstance(other, Vec):
            return NotImplemented
        return Vec(self.x / other, self.y / other)

    def __neg__(self) -> Vec:
        return Vec(-self.x, -self.y)
