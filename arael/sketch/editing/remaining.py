"""What must remain of a drawing when it has been solved: extents, and a finite size."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from arael.runtime.levels.compiled import largest, mostly_apart
from arael.sketch.editing import refusals
from arael.sketch.editing.checks import check_largest, check_remains
from arael.sketch.layout.layout import Layout
from arael.sketch.solve.extents import COLLAPSED
from arael.sketch.solve.solver import Solver

#: A drawing that grows to so many times its size is looked at twice.
_GROWS = 100.0
#: A drawing so many times larger than what is in it, usually, makes the rest of it vanish.
_DWARFS = 1e7

#: So many entities that moved are looked at one by one.
_FEW = 20

Floats = NDArray[np.float64]


class Remaining:
    """Looks at what a solve has made of a drawing, in single passes where nothing is wrong.

    Parameters
    ----------
    layout, solver : of the document
    """

    def __init__(self, layout: Layout, solver: Solver) -> None:
        self._document, self._layout, self._solver = layout.document, layout, solver
        self._looked = (-1, 0)  # at how many entities one by one, since any came or went

    def check(self, names: Sequence[str], old: Floats, size: float, cause: str = "") -> None:
        """Refuse what makes any of `names` collapse; see `arael.sketch.editing.checks`."""
        if len(names) <= _FEW and self._one_by_one(len(names)):
            check_remains(self._document, names, old, size, cause)
            return
        suspects = self._solver.extents.suspects(self._document.values, COLLAPSED * size)
        if suspects:
            moved = set(names)
            collapsed = [name for name in suspects if name in moved]
            check_remains(self._document, collapsed, old, size, cause)

    def _one_by_one(self, count: int) -> bool:
        """Whether so few entities are looked at without `Extents`.

        These have to be made from all entities whenever any came or went: that pays when as many
        were looked at one by one.
        """
        drawn = self._layout.drawn
        looked = self._looked[1] if self._looked[0] == drawn else 0
        if looked >= len(self._document.entities):
            return False
        self._looked = (drawn, looked + count)
        return True

    def check_all(self, before: Floats, size: float) -> None:
        """Refuse what leaves nothing of a line or circle, placing included; AraelError E1220."""
        check_largest([float(np.abs(self._document.values).max(initial=0.0))])
        self.check(list(self._document.entities), before, size)

    def is_drawing(self, values: Floats, size: float) -> bool:
        """Whether other numbers of the document, (N,), leave extents, and are not at infinity."""
        far = largest(values) > _GROWS * (largest(self._document.values) + size)
        return not far and not self._solver.extents.collapses(values, COLLAPSED * size)

    def check_near(self, before: Floats, size: float, moves: int) -> None:
        """Refuse a solution at infinity, where anything has moved since `moves`.

        Where a line cannot have the direction that it has to have, it comes as near to it as
        wanted by growing: everything is small relative to a drawing that large. A drawing that
        has grown is a solution if its equations hold by its old measure, or up to rounding; one
        that is far larger than it was and than every number that is given is none.
        """
        if self._document.moves == moves:
            return
        values = self._document.values
        far, old = largest(values), largest(before)
        if far > old and len(values) > 1:
            # Equations hold up to a share of the drawing's size: most of it would not hold.
            now = self._layout.size
            if now > size and not mostly_apart(values, 2.0 * now / _DWARFS):
                usual = float(np.median(np.abs(np.diff(values))))
                if size <= _DWARFS * usual < now:
                    raise refusals.runs_away()
        old += size
        if far <= _GROWS * old:
            return
        given = [abs(x) for one in self._document.constraints.values() for x in one.numbers]
        for one in self._document.dimensions.values():
            given += [abs(x.number) for x in (one.value, one.low, one.high) if x is not None]
        runs_away = far > _GROWS**2 * max(old, *given, 0.0)
        if runs_away or not self._solver.holds(max(1e-9 * size, 1e-13 * far)):
            raise refusals.runs_away()
