"""Operands of constraints and dimensions by the offsets of their numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple, Protocol

from arael.sketch.document.document import Document
from arael.sketch.document.handles import ends, point_offsets, split_handle
from arael.sketch.document.records import Entity
from arael.sketch.layout.plan import Values

Vector = tuple[float, float]


class Alike(Protocol):
    """What a plan asks about aliases."""

    def same(self, a: int, b: int) -> bool:
        """Whether two points are one place."""

    def lies_on(self, point: int, curve: str) -> bool:
        """Whether an equation of its own holds a point on a curve."""

    def on_both(self, first: str, second: str) -> int | None:
        """A point that equations of its own hold on both of two curves."""

    def piece_of(self, name: str) -> int | None:
        """On which piece of a spline a `point_on` is to be; None: on the nearest."""


class Circle(NamedTuple):
    """Centre and radius."""

    center: int
    r: int


class Ellipse(NamedTuple):
    """Centre, half axes, direction of the first."""

    center: int
    rx: int
    ry: int
    rot: int


@dataclass(frozen=True, slots=True)
class Operand:
    """An entity, or one of its points.

    Attributes
    ----------
    entity : of the document
    point : name of the point, empty for the entity
    at : offset of the point's x, or of the entity's first number
    """

    entity: Entity
    point: str
    at: int

    @property
    def kind(self) -> str:
        """``point`` for any point, else the entity's kind."""
        return "point" if self.point else self.entity.kind

    @property
    def line(self) -> tuple[int, int]:
        """Both ends of a line."""
        return self.entity.at, self.entity.at + 2

    @property
    def is_circular(self) -> bool:
        """Circle or arc."""
        return self.entity.kind in ("circle", "arc")

    @property
    def is_elliptic(self) -> bool:
        """Ellipse or elliptic arc."""
        return self.entity.kind in ("ellipse", "earc")

    @property
    def is_spline(self) -> bool:
        """Bezier or B-spline."""
        return self.entity.kind in ("bezier", "bspline")

    @property
    def circle(self) -> Circle:
        """Of a circle or an arc."""
        at = self.entity.at
        return Circle(at, at + (2 if self.entity.kind == "circle" else 6))

    @property
    def ellipse(self) -> Ellipse:
        """Of an ellipse or an elliptic arc."""
        at = self.entity.at
        first = at + (2 if self.entity.kind == "ellipse" else 6)
        return Ellipse(at, first, first + 1, first + 2)

    @property
    def center(self) -> int:
        """Centre of a round curve: its first point."""
        return self.entity.at

    @property
    def ends(self) -> tuple[int, ...]:
        """Points where a curve begins and ends; of arcs counter-clockwise, as their numbers run."""
        if self.entity.kind in ("arc", "earc"):
            return (self.entity.at + 2, self.entity.at + 4)
        points = point_offsets(self.entity)
        return tuple(points[name] for name in ends(self.entity))

    @property
    def poles(self) -> list[int]:
        """Poles of a spline; from its end, if the operand is its last point."""
        found = list(range(self.entity.at, self.entity.at + self.entity.size, 2))
        return found[::-1] if self.is_last else found

    @property
    def is_last(self) -> bool:
        """Whether a point is where its curve ends."""
        found = self.ends
        return len(found) == 2 and bool(self.point) and self.at == found[1]


def operand(entities: Mapping[str, Entity], handle: str) -> Operand:
    """The operand that a canonical handle names; a point entity is a point."""
    parts = split_handle(handle)
    if parts is None:
        raise KeyError(handle)
    entity = entities[parts.name]
    if parts.point:
        return Operand(entity, parts.point, point_offsets(entity)[parts.point])
    if entity.kind == "point":
        return Operand(entity, "pos", entity.at)
    return Operand(entity, "", entity.at)


def operands(document: Document, args: tuple[str, ...]) -> list[Operand]:
    """The operands of a constraint or dimension."""
    entities = document.entities
    return [operand(entities, arg) for arg in args]


# --- geometry of operands -----------------------------------------------------------------------


def place(values: Values, point: int) -> Vector:
    """Where a point is."""
    return float(values[point]), float(values[point + 1])


def towards(values: Values, a: int, b: int) -> Vector:
    """Vector from one point to another."""
    return float(values[b] - values[a]), float(values[b + 1] - values[a + 1])


def cross(u: Vector, v: Vector) -> float:
    """Cross product in the plane."""
    return u[0] * v[1] - u[1] * v[0]


def dot(u: Vector, v: Vector) -> float:
    """Dot product."""
    return u[0] * v[0] + u[1] * v[1]


def sign(number: float) -> int:
    """1 or -1; 1 where there is no sign."""
    return -1 if number < 0 else 1


def turn(u: Vector, v: Vector) -> float:
    """Angle from u counter-clockwise to v, in (-pi, pi]."""
    return math.atan2(cross(u, v), dot(u, v))


def forward(values: Values, end: Operand) -> Vector:
    """Direction in which a curve runs at one of its ends (from first to last point)."""
    entity = end.entity
    if entity.kind == "line":
        return towards(values, *end.line)
    if end.is_spline:
        poles = end.poles
        u = towards(values, poles[0], poles[1])
        return (-u[0], -u[1]) if end.is_last else u
    u = towards(values, end.center, end.at)
    if entity.kind == "arc":
        return -u[1], u[0]
    _, rx, ry, rot = end.ellipse
    c, s = math.cos(values[rot]), math.sin(values[rot])
    along, across = c * u[0] + s * u[1], c * u[1] - s * u[0]
    a, b = float(values[rx]), float(values[ry])
    v = (-across * a / b if b else 0.0, along * b / a if a else 0.0)
    return c * v[0] - s * v[1], s * v[0] + c * v[1]


def sweep_of(values: Values, arc: Operand) -> float:
    """Angle of an arc from its start counter-clockwise to its end, in (0, 2 pi]."""
    if arc.entity.kind == "circle":
        return 2 * math.pi
    start, end = arc.ends
    found = turn(towards(values, arc.center, start), towards(values, arc.center, end))
    return found if found > 0 else found + 2 * math.pi
