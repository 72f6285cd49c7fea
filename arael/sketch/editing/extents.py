"""Which entities have lost their extent, found for all at once."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from arael.runtime.levels.shared_numbers import any_short
from arael.sketch.document.records import Entity

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class Extents:
    """Where in a document's numbers the extents of its entities are.

    Parameters
    ----------
    entities : of the document
    """

    def __init__(self, entities: Iterable[Entity]) -> None:
        lines, radii, splines = [], [], []
        for entity in entities:
            end = entity.at + entity.size
            if entity.kind == "line":
                lines.append((entity.name, entity.at))
            elif entity.kind in ("circle", "arc"):
                radii.append((entity.name, end - 1))
            elif entity.kind in ("ellipse", "earc"):
                radii += [(entity.name, end - 3), (entity.name, end - 2)]
            elif entity.kind in ("bezier", "bspline"):
                splines.append(entity.name)
        self._lines, self._line_names = _split(lines)
        self._radii, self._radius_names = _split(radii)
        self._splines = splines

    def collapses(self, values: Floats, least: float) -> bool:
        """Whether a line or round curve has no extent above `least` at these numbers."""
        return bool(any_short(values, self._lines, self._radii, least))

    def suspects(self, values: Floats, least: float) -> list[str]:
        """Names of lines and round curves without an extent above `least`, and of all splines.

        Parameters
        ----------
        values : all numbers of the document
        """
        if not any_short(values, self._lines, self._radii, least):
            return list(self._splines)
        at = self._lines
        lengths = np.hypot(values[at + 2] - values[at], values[at + 3] - values[at + 1])
        found = [self._line_names[k] for k in np.flatnonzero(~(lengths > least))]
        small = np.flatnonzero(~(values[self._radii] > least))
        return [*found, *(self._radius_names[k] for k in small), *self._splines]


def _split(places: list[tuple[str, int]]) -> tuple[Ints, list[str]]:
    return np.array([at for _, at in places], dtype=np.int64), [name for name, _ in places]
