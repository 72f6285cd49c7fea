"""What has to be tried: whether some equations can be solved at all, and from where."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from arael.runtime.levels.levels import Levels
from arael.sketch.layout.layout import Layout

Floats = NDArray[np.float64]


class Trials:
    """Solves of a layout's equations on copies of its unknowns.

    Parameters
    ----------
    layout : its document is not changed
    """

    def __init__(self, layout: Layout) -> None:
        self.layout = layout
        self._levels: Levels | None = None

    @property
    def levels(self) -> Levels:
        """The solver, made when first needed."""
        self.layout.refresh()
        if self._levels is None:
            self._levels = Levels(self.layout.rows, guards=self.layout.guards)
        return self._levels

    def _solve(self, x: Floats, active: NDArray[np.bool_]) -> bool:
        layout = self.layout
        outcome = self.levels.solve(
            x, 1e-10 * layout.size, active=active, low=layout.low, high=layout.high
        )
        return outcome.solved

    def active(self, names: Iterable[str]) -> NDArray[np.bool_]:
        """Mask of the rows of some constraints and dimensions, and of all entities' own."""
        layout = self.layout
        found = np.zeros(layout.rows.m, dtype=bool)
        for name in (*names, *layout.document.entities):
            found[layout.first_rows(name)] = True
        return found

    def solved_from(self, x: Floats, without: str = "") -> Floats | None:
        """Unknowns by column at which the equations but those of `without` hold; None if nowhere.

        Parameters
        ----------
        x : unknowns by column to start from
        """
        layout, document = self.layout, self.layout.document
        full = layout.with_unknowns(x)
        names = [one for one in (*document.constraints, *document.dimensions) if one != without]
        if not self._solve(full, self.active(names)):
            return None
        found: Floats = full[layout.unknowns[: len(x)]]
        return found

    def feasible(self, names: Iterable[str]) -> bool:
        """Whether these constraints and dimensions hold together with entities' own equations."""
        x = self.layout.gather().copy()
        return self._solve(x, self.active(names))
