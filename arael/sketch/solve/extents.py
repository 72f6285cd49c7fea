"""What has to be above zero of an entity, and which have lost it, found for all at once."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from arael.runtime.levels.compiled import any_short
from arael.sketch.document.records import Entity

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

#: What has shrunk to this part of the sketch's size in a solve has collapsed.
COLLAPSED = 1e-8
#: An ellipse with a radius of this part of the other is a line there and back.
FLAT = 1e-6


def extents_of(kind: str, numbers: list[float]) -> list[tuple[str, float]]:
    """What has to be above zero, with its name."""
    if kind == "line":
        return [("length", math.dist(numbers[:2], numbers[2:]))]
    if kind in ("circle", "arc"):
        return [("radius", numbers[-1])]
    if kind in ("ellipse", "earc"):
        return [("radius", numbers[-3]), ("second radius", numbers[-2])]
    if kind in ("bezier", "bspline"):
        places = range(2, len(numbers), 2)
        return [("extent", max(math.dist(numbers[:2], numbers[i : i + 2]) for i in places))]
    return []


def lost(entity: Entity, before: Floats, now: Floats, least: float) -> str:
    """What of an entity has collapsed between two states of a document's numbers; empty: nothing.

    What was as small as `least` already, as the drawing grew, still keeps its direction: it has
    collapsed where it is zero. The same goes for an ellipse that was flat.
    """
    own = slice(entity.at, entity.at + entity.size)
    old = extents_of(entity.kind, before[own].tolist())
    new = extents_of(entity.kind, now[own].tolist())
    flat, flat_before = _flat_below(entity.kind, new), _flat_below(entity.kind, old)
    for (what, found), (_, was) in zip(new, old, strict=True):
        if not found > (least if was > least else 0.0) and was > 0.0:
            return what
        if was > flat_before and not found > flat:
            return what
    return ""


def _flat_below(kind: str, extents: list[tuple[str, float]]) -> float:
    """The radius up to which an ellipse with these is flat; 0 for other kinds."""
    if kind not in ("ellipse", "earc"):
        return 0.0
    return FLAT * max(extent for _, extent in extents)


class Extents:
    """Where in a document's numbers the extents of its entities are.

    Parameters
    ----------
    entities : of the document
    """

    def __init__(self, entities: Iterable[Entity]) -> None:
        lines, radii, ellipses, splines = [], [], [], []
        self._entities = {entity.name: entity for entity in entities}
        for entity in self._entities.values():
            end = entity.at + entity.size
            if entity.kind == "line":
                lines.append((entity.name, entity.at))
            elif entity.kind in ("circle", "arc"):
                radii.append((entity.name, end - 1))
            elif entity.kind in ("ellipse", "earc"):
                ellipses.append((entity.name, end - 3))
            elif entity.kind in ("bezier", "bspline"):
                splines.append(entity.name)
        radii += [(name, at + k) for name, at in ellipses for k in (0, 1)]
        self._lines, self._line_names = _split(lines)
        self._radii, self._radius_names = _split(radii)
        self._ellipses, self._ellipse_names = _split(ellipses)
        self._splines = splines

    def collapses(self, values: Floats, least: float) -> bool:
        """Whether a line or round curve has no extent above `least`, or an ellipse is flat."""
        return any_short(values, self._lines, self._radii, least) or bool(self._flat(values))

    def lost(self, before: Floats, now: Floats, least: float) -> list[Entity]:
        """What has collapsed between two states of the document's numbers."""
        suspects = [self._entities[name] for name in self.suspects(now, least)]
        return [entity for entity in suspects if lost(entity, before, now, least)]

    def suspects(self, values: Floats, least: float) -> list[str]:
        """Names of lines and round curves without an extent above `least` or flat; of all splines.

        Parameters
        ----------
        values : all numbers of the document
        """
        found = self._flat(values)
        if not any_short(values, self._lines, self._radii, least):
            return [*found, *self._splines]
        at = self._lines
        lengths = np.hypot(values[at + 2] - values[at], values[at + 3] - values[at + 1])
        found += [self._line_names[k] for k in np.flatnonzero(~(lengths > least))]
        small = np.flatnonzero(~(values[self._radii] > least))
        found += [self._radius_names[k] for k in small]
        return [*dict.fromkeys(found), *self._splines]

    def _flat(self, values: Floats) -> list[str]:
        """Names of the flat ellipses."""
        at = self._ellipses
        if not len(at):
            return []
        radii = np.stack([values[at], values[at + 1]])
        flat = ~(radii.min(axis=0) > FLAT * radii.max(axis=0))
        return [self._ellipse_names[k] for k in np.flatnonzero(flat)]


def _split(places: list[tuple[str, int]]) -> tuple[Ints, list[str]]:
    return np.array([at for _, at in places], dtype=np.int64), [name for name, _ in places]
