"""A part of a drawing that no equation connects with the rest, numbered by itself."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from arael.runtime.levels.compiled import Excerpt, components

if TYPE_CHECKING:
    from arael.sketch.layout.layout import Layout

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class Part:
    """Equations, guards and unknowns of some records; as long as the layout is as it was.

    Parameters
    ----------
    layout : of the document
    names : of entities, constraints and dimensions: all that hang together with any of them

    Attributes
    ----------
    layout
    rows, guards : with unknowns numbered within the part
    numbers : (k,) offsets of the part's numbers in the document's values
    columns : (n,) index in the layout's `x`, by unknown
    owner, guard_owner : names of records by row, as of the layout
    """

    def __init__(self, layout: Layout, names: Sequence[str]) -> None:
        self.layout, self._names = layout, names
        rows, guards, quantities = layout.instances_of(names)
        self.numbers = layout.numbers_in(names)
        self.columns, self._own = np.unique(layout.roots(self.numbers), return_inverse=True)
        self.rows = Excerpt(layout.rows, rows, quantities, self.columns)
        self.guards = Excerpt(layout.guards, guards, (), self.columns)
        self.owner = [layout.owner[row] for row in self.rows.row_of.tolist()]
        self.guard_owner = [layout.guard_owner[row] for row in self.guards.row_of.tolist()]
        self._row = {row: k for k, row in enumerate(self.rows.row_of.tolist())}
        self._guard = {row: k for k, row in enumerate(self.guards.row_of.tolist())}

    def gather(self) -> Floats:
        """Unknowns from the document's numbers, (n,)."""
        return self.layout.gather()[self.columns]

    def local(self, rows: Sequence[int]) -> list[int]:
        """Rows of the part for rows of the layout."""
        return [self._row[row] for row in rows]

    def struct_of_guard(self, guard: int) -> str:
        """Name of the struct that a row of `guards` begins."""
        return self.layout.struct_of_guard(int(self.guards.row_of[guard]))

    def changed(self, key: tuple[str, int]) -> bool:
        """Whether a value that changed, by ``rows`` or ``guards`` and its row, is the part's."""
        which, row = key
        return row in (self._row if which == "rows" else self._guard)

    def scatter(self, x: Floats) -> tuple[str, ...]:
        """Solved unknowns, (n,), into the document; names of entities whose numbers changed."""
        return self.layout.scatter_numbers(self.numbers, x[self._own], self.columns, x)

    def line_ends(self) -> Ints:
        """As of the layout."""
        ends = self.layout.lines_in(self._names)[:, None] + np.arange(4)
        found: Ints = np.searchsorted(self.columns, self.layout.roots(ends))
        return found

    def held(self) -> NDArray[np.bool_]:
        """As of the layout."""
        found = np.zeros(len(self.columns), dtype=bool)
        held = self.layout.roots(self.layout.held_numbers(self.numbers))
        found[np.searchsorted(self.columns, held)] = True
        return found

    # --- as a layout has them, for tolerances ------------------------------------------------

    @property
    def size(self) -> float:
        """Of the whole drawing."""
        return self.layout.size

    def axes(self) -> NDArray[np.int8]:
        """What each unknown is, as of the layout."""
        found = np.zeros(len(self.columns), dtype=np.int8)
        found[self._own] = self.layout.axis_of(self.numbers)
        return found

    def components(self) -> NDArray[np.int32]:
        """Number of the component by row, then by unknown."""
        return components(self.rows)
