"""Affine maps of the plane: moves, turns, mirrors, scalings, and what SVG's `transform` writes."""

from __future__ import annotations

from math import cos, hypot, sin

import msgspec

from arael.sketch.geometry.vectors import Point, subtract, unit


class Affine(msgspec.Struct, frozen=True):
    """The map (x, y) -> (a x + c y + e, b x + d y + f); the order of letters is SVG's `matrix`."""

    a: float = 1.0
    b: float = 0.0
    c: float = 0.0
    d: float = 1.0
    e: float = 0.0
    f: float = 0.0

    @classmethod
    def shift(cls, by: Point) -> Affine:
        """Translation."""
        return cls(e=by[0], f=by[1])

    @classmethod
    def rotation(cls, angle: float, about: Point = (0.0, 0.0)) -> Affine:
        """Turn by `angle` (radians, counter-clockwise) about a point."""
        return cls._about(cos(angle), sin(angle), -sin(angle), cos(angle), about)

    @classmethod
    def scaling(cls, factor: float, about: Point = (0.0, 0.0)) -> Affine:
        """Uniform scaling about a point."""
        return cls._about(factor, 0.0, 0.0, factor, about)

    @classmethod
    def mirror(cls, p1: Point, p2: Point) -> Affine:
        """Reflection about the line through two points."""
        x, y = unit(subtract(p2, p1))
        return cls._about(x * x - y * y, 2 * x * y, 2 * x * y, y * y - x * x, p1)

    @classmethod
    def _about(cls, a: float, b: float, c: float, d: float, at: Point) -> Affine:
        return cls(a, b, c, d, at[0] - a * at[0] - c * at[1], at[1] - b * at[0] - d * at[1])

    def __call__(self, p: Point) -> Point:
        """Image of a point."""
        return self.a * p[0] + self.c * p[1] + self.e, self.b * p[0] + self.d * p[1] + self.f

    def direction(self, v: Point) -> Point:
        """Image of a vector."""
        return self.a * v[0] + self.c * v[1], self.b * v[0] + self.d * v[1]

    def after(self, first: Affine) -> Affine:
        """The map that applies `first` and then this one (matrix product self * first)."""
        a, b = self.direction((first.a, first.b))
        c, d = self.direction((first.c, first.d))
        e, f = self((first.e, first.f))
        return Affine(a, b, c, d, e, f)

    @property
    def determinant(self) -> float:
        """Factor of areas; negative for maps that mirror."""
        return self.a * self.d - self.b * self.c

    @property
    def factor(self) -> float | None:
        """Factor of lengths if the map keeps shapes (a similarity), otherwise None."""
        size = hypot(self.a, self.b)
        sign = 1.0 if self.determinant >= 0 else -1.0
        off = hypot(self.a - sign * self.d, self.b + sign * self.c)
        return size if off <= 1e-14 * size else None
