"""An entity that was cut: its pieces, and which of them owns a point or a place."""

from __future__ import annotations

from dataclasses import dataclass

from arael.sketch.document.document import Document
from arael.sketch.document.handles import ends
from arael.sketch.document.records import Entity
from arael.sketch.geometry import Curve


@dataclass(frozen=True, slots=True)
class Part:
    """A piece of a curve.

    Attributes
    ----------
    entity : the new one
    start, end : parameters of the old curve, start < end; of a closed curve up to 1 beyond
    """

    entity: Entity
    start: float
    end: float

    def contains(self, t: float, closed: bool) -> bool:
        """Whether a parameter of the old curve lies on it, ends included up to rounding."""
        slack = 1e-9
        turns = (0.0, 1.0, -1.0) if closed else (0.0,)
        return any(self.start - slack <= t + turn <= self.end + slack for turn in turns)


@dataclass(frozen=True, slots=True)
class Division:
    """A cut of an entity.

    Attributes
    ----------
    old : the entity that was cut, still in the document
    curve : its shape
    parts : the pieces that are kept, in the direction of the entity
    whole : whether all of the old curve is kept
    """

    document: Document
    old: Entity
    curve: Curve
    parts: tuple[Part, ...]
    whole: bool

    def successor(self, point: str) -> str | None:
        """Handle of the point that takes the place of one of the old entity's, None if gone."""
        if not self.parts:
            return None
        if point == "center":
            return f"{self.parts[0].entity.name}.center"
        names = ends(self.old)
        if self.old.kind in ("bezier", "bspline"):
            count = self.old.size // 2
            point = {"pole1": "p1", f"pole{count}": "p2"}.get(point, point)
        if point not in names:
            return None
        first = point == names[0]
        at_start = first != self.old.clockwise
        t = 0.0 if at_start else 1.0
        part = self.parts[0] if first else self.parts[-1]
        reached = part.start == t if at_start else part.end == t
        return f"{part.entity.name}.{point}" if reached else None

    def at(self, x: float, y: float) -> Part | None:
        """The kept piece that contains the foot of a point, None if that was cut away."""
        t = self.curve.nearest((x, y)).t
        return next((p for p in self.parts if p.contains(t, self.curve.closed)), None)

    def joints(self) -> list[tuple[Part, Part]]:
        """Neighbouring kept pieces that meet, in the direction of the entity."""
        found = []
        for a, b in zip(self.parts, self.parts[1:], strict=False):
            if self._meet(a, b):
                found.append((a, b))
        closed = self.curve.closed and len(self.parts) > 1
        if closed and self._meet(self.parts[-1], self.parts[0]):
            found.append((self.parts[-1], self.parts[0]))
        return found

    def _meet(self, a: Part, b: Part) -> bool:
        if self.old.clockwise:
            a, b = b, a
        return abs(a.end - b.start) < 1e-12 or (
            self.curve.closed and abs(a.end - b.start - 1.0) < 1e-12
        )


def low_end(entity: Entity) -> str:
    """Name of the point where the numbers of an entity begin."""
    return ends(entity)[1 if entity.clockwise else 0]


def high_end(entity: Entity) -> str:
    """Name of the point where the numbers of an entity end."""
    return ends(entity)[0 if entity.clockwise else 1]
