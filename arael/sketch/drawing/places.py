"""Free places: rectangles that are taken, so that texts and glyphs do not overlap."""

from __future__ import annotations

from collections.abc import Iterable

from arael.sketch.geometry import Point

_CELL = 32.0


class Places:
    """Rectangles by centre and half sizes, found by a grid."""

    def __init__(self) -> None:
        self._grid: dict[tuple[int, int], list[tuple[float, float, float, float]]] = {}

    def _cells(self, x: float, y: float, w: float, h: float) -> Iterable[tuple[int, int]]:
        for i in range(int((x - w) // _CELL), int((x + w) // _CELL) + 1):
            for j in range(int((y - h) // _CELL), int((y + h) // _CELL) + 1):
                yield i, j

    def is_free(self, x: float, y: float, w: float, h: float) -> bool:
        """Whether a rectangle of half sizes w, h overlaps none that is taken."""
        return not any(
            abs(x - ox) < w + ow and abs(y - oy) < h + oh
            for cell in self._cells(x, y, w, h)
            for ox, oy, ow, oh in self._grid.get(cell, ())
        )

    def take(self, x: float, y: float, w: float, h: float) -> None:
        """Mark a rectangle as taken."""
        for cell in self._cells(x, y, w, h):
            self._grid.setdefault(cell, []).append((x, y, w, h))

    def first_free(self, candidates: Iterable[Point], w: float, h: float) -> Point:
        """The first free place, which is then taken; the first candidate if none is free."""
        found = list(candidates)
        at = next((one for one in found if self.is_free(*one, w, h)), found[0])
        self.take(*at, w, h)
        return at
