"""How small residuals have to be, by row: relative to the size of the component they belong to."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arael.runtime.levels.compiled import ComponentSizes
from arael.sketch.layout.layout import Layout
from arael.sketch.layout.part import Part

#: Largest residual of a solved sketch, relative to the size of its component.
TOLERANCE = 1e-10
#: Residuals are differences of coordinates, and no smaller than so many roundings of these.
ROUNDINGS = 16.0

_SMALLEST = ROUNDINGS * float(np.finfo(float).eps)


class Tolerances:
    """Tolerances of the rows of a layout.

    What depends on the structure alone is kept: where a component's unknowns are.

    Parameters
    ----------
    layout : whose rows, or a part of one
    """

    def __init__(self, layout: Layout | Part) -> None:
        self._layout = layout
        label = layout.components()
        m = layout.rows.m
        self._sizes = ComponentSizes(layout.axes(), label[m:], label[:m])

    def at(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Tolerances of all rows, (m,), where unknowns are at `x`."""
        return self._sizes.tolerances(x, TOLERANCE, _SMALLEST, lambda: self._layout.size)
