"""Points of a sketch by place: what a new end may be connected to."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arael.runtime.levels.compiled import near
from arael.sketch.document.document import Document
from arael.sketch.document.handles import point_offsets
from arael.sketch.document.history import RecordChange
from arael.sketch.document.records import Entity


def own_points(entity: Entity) -> dict[str, int]:
    """Handles and offsets of the points that connect by themselves: all but inner poles."""
    return {
        entity.name if entity.kind == "point" else f"{entity.name}.{point}": at
        for point, at in point_offsets(entity).items()
        if not point.startswith("pole")
    }


class Points:
    """All points of a document, kept up to date with it."""

    def __init__(self, document: Document) -> None:
        self._document = document
        self._handles: list[str] = []
        self._offsets: NDArray[np.int64] = np.zeros(64, dtype=np.int64)  # longer than the handles
        self._stale = True
        document.watchers.append(self._changed)

    def _changed(self, change: RecordChange, backwards: bool) -> None:
        if change.table != "entities" or (change.old is not None and change.new is not None):
            return
        record = change.old if backwards else change.new
        if isinstance(record, Entity) and not self._stale and change.order is None:
            self._add(record)
        else:
            self._stale = True

    def _add(self, entity: Entity) -> None:
        points = own_points(entity)
        first = len(self._handles)
        self._handles += points
        if len(self._handles) > len(self._offsets):
            self._offsets = np.resize(self._offsets, 2 * len(self._handles))
        self._offsets[first : len(self._handles)] = list(points.values())

    def near(self, x: float, y: float, distance: float) -> list[str]:
        """Handles of the points within a distance, in the order they were made."""
        if self._stale:
            self._handles = []
            for entity in self._document.entities.values():
                self._add(entity)
            self._stale = False
        at = self._offsets[: len(self._handles)]
        return [self._handles[k] for k in near(self._document.values, at, x, y, distance)]
