"""Free places: rectangles that are taken, so that texts and glyphs do not overlap."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from math import ceil, hypot

from arael.sketch.geometry import Point

_CELL = 32.0


class Places:
    """Rectangles by centre and half sizes, found by a grid."""

    def __init__(self) -> None:
        self._grid: dict[tuple[int, int], list[tuple[float, float, float, float]]] = {}
        self._texts: list[tuple[float, float, float, float]] = []

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

    def take_line(self, p: Point, q: Point) -> None:
        """Let texts and badges keep off a line."""
        count = min(ceil(hypot(q[0] - p[0], q[1] - p[1]) / 16), 100)
        for i in range(1, count):
            f = i / count
            self.take(p[0] + f * (q[0] - p[0]), p[1] + f * (q[1] - p[1]), 3.0, 3.0)

    def first_free(
        self,
        candidates: Iterable[Point],
        w: float,
        h: float,
        line: Callable[[Point], tuple[Point, Point]] | None = None,
    ) -> Point:
        """The first free place, which is then taken; the first candidate if none is free.

        A place whose line passes through a text is taken only where no other is free.

        Parameters
        ----------
        candidates, w, h : centres and half sizes of a text
        line : ends of the line that goes with a text at a candidate; none by default
        """
        spots = list(candidates)
        free = [spot for spot in spots if self.is_free(*spot, w, h)]
        clear = (spot for spot in free if not (line and self._passes(*line(spot))))
        at = next(clear, free[0] if free else spots[0])
        self.take(*at, w, h)
        self._texts.append((*at, w, h))
        return at

    def _passes(self, p: Point, q: Point) -> bool:
        """Whether a line passes through a text."""
        count = min(ceil(hypot(q[0] - p[0], q[1] - p[1]) / 6), 300)
        points = [
            (p[0] + i / max(count, 1) * (q[0] - p[0]), p[1] + i / max(count, 1) * (q[1] - p[1]))
            for i in range(count + 1)
        ]
        return any(
            abs(x - ox) < 1 + w and abs(y - oy) < 1 + h
            for ox, oy, w, h in self._texts
            for x, y in points
        )
