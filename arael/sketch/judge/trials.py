"""What has to be tried: whether some equations can be solved at all, and from where."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from arael.runtime.levels.levels import Levels
from arael.sketch.judge.system import Floats
from arael.sketch.layout.layout import Layout


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
        layout = self.layout
        layout.refresh()
        if self._levels is None:
            self._levels = Levels(layout.rows, layout.guards, layout.low, layout.high)
        else:
            self._levels.set_bounds(layout.low, layout.high)
        return self._levels

    def tolerance(self, place: Floats) -> float:
        """Largest residual of what counts as solved."""
        used = place[self.layout.unknowns]
        size = float(np.ptp(used)) if len(used) else 0.0
        return 1e-10 * (size or 1.0)

    def active(
        self, leave: Iterable[str] = (), only: Iterable[str] | None = None
    ) -> NDArray[np.bool_]:
        """Mask of rows: all equations but those of some records, or entities' and some only."""
        layout = self.layout
        found = np.zeros(layout.rows.m, dtype=bool)
        rows = np.array(layout.equations(), dtype=np.int64)
        if only is not None:
            kept = set(only)
            entities = layout.document.entities
            rows = np.array(
                [
                    r
                    for r in rows.tolist()
                    if layout.owner[r] in kept or layout.owner[r] in entities
                ],
                dtype=np.int64,
            )
        gone = set(leave)
        if gone:
            rows = np.array(
                [r for r in rows.tolist() if layout.owner[r] not in gone], dtype=np.int64
            )
        found[rows] = True
        return found

    def solved_from(self, place: Floats, without: str = "") -> Floats | None:
        """Where the equations but those of `without` hold, from a place on; None if nowhere."""
        levels = self.levels
        x = place.copy()
        outcome = levels.solve(x, self.tolerance(place), self.active(leave=[without]))
        levels.forget()
        return x if outcome.solved else None

    def feasible(self, names: Iterable[str], place: Floats | None = None) -> bool:
        """Whether these constraints and dimensions hold together with entities' own equations."""
        levels = self.levels
        start = self.layout.gather() if place is None else place
        x = start.copy()
        outcome = levels.solve(x, self.tolerance(start), self.active(only=names))
        levels.forget()
        return outcome.solved
