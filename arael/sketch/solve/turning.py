"""Which way lines and radii point at the places they share, and how far a step turns them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arael.sketch.document.document import Document

Array = NDArray[np.float64]

#: Cosine of the angle by which a step that looks continuous turns a line at most: 45 degrees.
MOST_TURN = np.sqrt(0.5)


class Turning:
    """Lines, and radii of arcs, with the pairs of them that share a place.

    An assembly of links differs from its mirror image in the order of turning at such places.

    Parameters
    ----------
    document : as it is now; places are shared where their coordinates are the same bits
    """

    def __init__(self, document: Document) -> None:
        ends: list[tuple[int, int]] = []
        for one in document.entities.values():
            if one.kind == "line":
                ends.append((one.at, one.at + 2))
            elif one.kind in ("arc", "earc"):
                ends += [(one.at, one.at + 2), (one.at, one.at + 4)]
        self._from = np.array([a for a, _ in ends], dtype=np.int64)
        self._to = np.array([b for _, b in ends], dtype=np.int64)
        values = document.values
        at = np.concatenate([self._from, self._to])
        places = np.ascontiguousarray(np.column_stack([values[at], values[at + 1]])) + 0.0
        order = np.lexsort(places.T)
        same = (places[order[1:]] == places[order[:-1]]).all(axis=1)
        count = max(len(ends), 1)
        self._first, self._second = order[:-1][same] % count, order[1:][same] % count

    def change(self, before: Array, after: Array) -> tuple[bool, bool]:
        """Whether a step turns a line by more than 45 degrees, and whether it passes another.

        Parameters
        ----------
        before, after : numbers of the document
        """
        if not len(self._from):
            return False, False
        old, new = self._ways(before), self._ways(after)
        cosine = (old * new.conj()).real
        turned = bool((cosine < MOST_TURN * np.abs(old) * np.abs(new)).any())
        a, b = self._first, self._second
        was, now = (old[a].conj() * old[b]).imag, (new[a].conj() * new[b]).imag
        return turned, bool((was * now < 0.0).any())

    def _ways(self, values: Array) -> NDArray[np.complex128]:
        """Ends less beginnings, as complex numbers."""
        x = values[self._to] - values[self._from]
        found: NDArray[np.complex128] = x + 1j * (values[self._to + 1] - values[self._from + 1])
        return found
