"""How small residuals have to be, by row: relative to the size of the component they belong to."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arael.sketch.layout.layout import Layout

#: Largest residual of a solved sketch, relative to the size of its component.
TOLERANCE = 1e-10
#: Residuals are differences of coordinates, and no smaller than so many roundings of these.
ROUNDINGS = 16.0


class Tolerances:
    """Tolerances of the rows of a layout.

    What depends on the structure alone is kept: where a component's unknowns are.

    Parameters
    ----------
    layout : whose rows
    """

    def __init__(self, layout: Layout) -> None:
        self._layout = layout
        label = layout.components()
        self._row, component = label[: layout.rows.m], label[layout.rows.m :]
        # By component, x and y apart: the numbers of its places, fixed ones left out.
        axes = layout.axes()
        self._at: list[NDArray[np.int64]] = []
        self._starts: list[NDArray[np.int64]] = []
        self._ids: list[NDArray[np.int64]] = []
        for axis in (1, 2, 3):
            at = np.flatnonzero(axes == axis)
            at = at[np.argsort(component[at], kind="stable")]
            ids, starts = np.unique(component[at], return_index=True)
            self._at.append(at.astype(np.int64))
            self._starts.append(starts)
            self._ids.append(ids.astype(np.int64))
        self._count = int(label.max(initial=-1)) + 1
        # A solve asks before it starts, and again where it starts.
        self._last: tuple[NDArray[np.float64], NDArray[np.float64]] | None = None

    def at(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Tolerances of all rows, (m,), where unknowns are at `x`; not to be written to."""
        if self._last is None or not np.array_equal(self._last[0], x):
            self._last = (x.copy(), self._computed(x))
        return self._last[1]

    def _computed(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        size = np.zeros(self._count)
        far = np.zeros(self._count)
        for axis, at, starts, ids in zip((1, 2, 3), self._at, self._starts, self._ids, strict=True):
            if not len(at):
                continue
            values = x[at]
            high, low = np.maximum.reduceat(values, starts), np.minimum.reduceat(values, starts)
            top = np.maximum(np.abs(high), np.abs(low))
            size[ids] = np.maximum(size[ids], top if axis == 3 else high - low)
            far[ids] = np.maximum(far[ids], top)
        # A component without extent is as large as the largest.
        whole = float(size.max(initial=0.0)) or self._layout.size
        size[size <= 1e-9 * whole] = whole
        tolerance = np.maximum(TOLERANCE * size, ROUNDINGS * np.finfo(float).eps * far)
        found: NDArray[np.float64] = tolerance[self._row]
        return found
