"""The unknowns and equations around what is open, as a small dense problem."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from arael.sketch.solve.extents import COLLAPSED

if TYPE_CHECKING:
    from arael.runtime.levels.compiled import Rows
    from arael.sketch.solve.solver import Solver

Array = NDArray[np.float64]

#: Unknowns of the problem, those next to the open equations first: the rest does not move.
MOST_UNKNOWNS = 120
#: Fractions of its multiples are spread evenly, in no relation to each other.
_GOLDEN = 0.5 * (5.0**0.5 - 1.0)


class Region:
    """Equations that do not hold, all that hangs together with them, and the sides to be kept.

    Parameters
    ----------
    solver : with the new values set, and prepared
    x : (n,) unknowns of the layout; not changed
    names : constraints and dimensions that count, with the equations of entities; all without
    most : unknowns at most

    Attributes
    ----------
    is_open : whether an equation does not hold that can be moved, and the region is not too large
    is_large : whether it is
    active : (m,) which rows of the layout count; None: all
    rows : chosen equations
    columns : chosen unknowns
    scale : (n,) typical sizes of the unknowns
    low, high : (n,) bounds
    size : of the figure, the same wherever it is and however it is turned
    """

    def __init__(
        self,
        solver: Solver,
        x: Array,
        names: Sequence[str] | None = None,
        most: int = MOST_UNKNOWNS,
    ) -> None:
        self._solver, self._most = solver, most
        layout = solver.layout
        self._rows, self._guards = layout.rows, layout.guards
        low, high = layout.bounds
        self.low = np.full(len(x), -np.inf) if low is None else low
        self.high = np.full(len(x), np.inf) if high is None else high
        scales = solver.levels.scales
        self.scale = np.ones(len(x)) if scales is None else np.asarray(scales)
        self.active = None if names is None else solver.rows_of(names)
        counted = None if names is None else {*layout.document.entities, *names}
        # An arc whose sweep or length is asked for may pass half a turn, where its guard is zero.
        asked = self._asked(x)
        self._kept = np.zeros(self._guards.m, dtype=bool)
        for row in self._guards.instances().tolist():
            owner, sweep = layout.guard_owner[row], self._guards.struct(row) == "SweepGuard"
            self._kept[row] = (counted is None or owner in counted) and not (
                sweep and owner in asked
            )
        self._kept &= self._guards.evaluate(x) > 0.0
        self.is_large = False
        self.is_open = self._choose(x)

    def _asked(self, x: Array) -> set[str]:
        """Entities whose sweep or length is not what it is to be."""
        layout = self._solver.layout
        open_ = np.abs(self._rows.evaluate(x)) > self._solver.tolerances.at(x)
        dimensions = layout.document.dimensions
        found: set[str] = set()
        for name in {layout.owner[row] for row in np.flatnonzero(open_)} & dimensions.keys():
            if dimensions[name].kind in ("sweep", "arc_length"):
                found.update(dimensions[name].args)
        return found

    def _choose(self, x: Array) -> bool:
        rows = self._rows
        residuals = rows.evaluate(x)
        if not np.isfinite(residuals).all() or not len(residuals):
            return False
        pattern, sides = _pattern(rows), _pattern(self._guards)
        counts = np.ones(rows.m, dtype=bool) if self.active is None else self.active
        near = (np.abs(residuals) > self._solver.tolerances.at(x)) & counts
        reached = near @ pattern > 0
        self.is_large = bool(reached.sum() > self._most)
        if not reached.any() or self.is_large:
            return False
        while True:
            wider = (reached @ pattern.T > 0) & counts, (reached @ sides.T > 0) & self._kept
            more = reached | (wider[0] @ pattern > 0) | (wider[1] @ sides > 0)
            if more.sum() == reached.sum() or more.sum() > self._most:
                break
            reached = more
        self.columns = np.flatnonzero(reached)
        self.rows = np.flatnonzero(wider[0])
        self._equations = _chosen(rows, self.rows, self.columns)
        self._sides = _chosen(self._guards, np.flatnonzero(wider[1]), self.columns)
        self._lines = self._lines_in(reached, x)
        self._measure(x)
        return True

    def _measure(self, x: Array) -> None:
        """The figure's size, and a direction of its own: between its first places that differ."""
        axes = self._solver.layout.axes()
        of = axes[self.columns]
        xs = (self.columns[of == 1], self.columns[of == 2] - 1, *self._lines[:, ::2].T)
        points = np.unique(np.concatenate(xs))
        places = x[points] + 1j * x[points + 1]
        spread = np.abs(places - places.mean()) if len(places) else np.zeros(1)
        lengths = np.abs(x[self.columns[of == 3]])
        size = 2.0 * max(float(np.sqrt(np.square(spread).mean())), lengths.max(initial=0.0))
        self.size = size or self._solver.layout.size
        ways = places - places[:1]
        ways = ways[np.abs(ways) > COLLAPSED * self.size]
        self._direction = complex(ways[0] / abs(ways[0])) if len(ways) else 1.0 + 0.0j

    def nudge(self, way: float, least: float = -1.0) -> Array:
        """Numbers from `least` to 1 for the scaled unknowns, along the directions of the figure.

        They are the same, turned along, where the figure is drawn elsewhere.

        Parameters
        ----------
        way : others for another
        """
        axes = self._solver.layout.axes()
        found = np.modf(way + _GOLDEN * np.arange(1.0, len(axes) + 1.0))[0]
        found = least + (1.0 - least) * found
        xs = np.flatnonzero(axes == 1)
        turned = self._direction * (found[xs] + 1j * found[xs + 1])
        found[xs], found[xs + 1] = turned.real, turned.imag
        chosen: Array = found[self.columns]
        return chosen

    def reach(self, way: Array) -> float:
        """How far a change of the chosen unknowns moves a point, or another number, at most."""
        axes = self._solver.layout.axes()
        moved = np.zeros(len(axes))
        moved[self.columns] = way
        xs = np.flatnonzero(axes == 1)
        apart = np.hypot(moved[xs], moved[xs + 1]).max(initial=0.0)
        others = np.abs(moved[(axes != 1) & (axes != 2)]).max(initial=0.0)
        return float(max(apart, others))

    def _lines_in(self, reached: NDArray[np.bool_], x: Array) -> NDArray[np.int64]:
        """Where in `x` the ends of lines are (k, 4) that can become longer or shorter."""
        layout = self._solver.layout
        roots = layout.line_ends()
        roots = roots[reached[roots].any(axis=1)]
        return roots[_lengths(x, roots) > COLLAPSED * layout.size]

    # --- at a state -----------------------------------------------------------------------------

    def residuals(self, x: Array) -> Array:
        """Of the region's equations."""
        found: Array = self._rows.evaluate(x)[self.rows]
        return found

    def linearised(self, x: Array) -> tuple[Array, Array]:
        """Residuals, and their scaled derivatives by the chosen unknowns."""
        return self._dense(self._rows, x, self._equations)

    def _dense(self, rows: Rows, x: Array, chosen: _Chosen) -> tuple[Array, Array]:
        residuals, entries = rows.jacobian(x)
        count, width = chosen.shape
        flat: Array = np.bincount(chosen.places, entries[chosen.entries], count * width)  # type: ignore[assignment]
        return residuals[chosen.rows], flat.reshape(chosen.shape) * self.scale[self.columns]

    def sides_at(self, x: Array) -> tuple[Array, Array]:
        """What stays positive, lengths of lines as well, and its derivatives as of `linearised`."""
        sides, slopes = self._dense(self._guards, x, self._sides)
        lengths = _lengths(x, self._lines)
        column = np.full(len(x), -1, dtype=np.int64)
        column[self.columns] = np.arange(len(self.columns))
        more = np.zeros((len(lengths), len(self.columns)))
        for k in range(2):
            way = (x[self._lines[:, k + 2]] - x[self._lines[:, k]]) / lengths
            for at, sign in ((k, -1.0), (k + 2, 1.0)):
                to = column[self._lines[:, at]]
                own = np.flatnonzero(to >= 0)
                np.add.at(more, (own, to[own]), sign * way[own])
        more *= self.scale[self.columns]
        return np.concatenate([sides, lengths]), np.vstack([slopes, more])

    def keeps_sides(self, x: Array) -> bool:
        """Whether the sides of the region, and all others that are to be kept, are kept."""
        return bool((self._guards.evaluate(x)[self._kept] > 0.0).all())

    def holds(self, x: Array) -> bool:
        """Whether all equations that count hold."""
        tolerance = self._solver.tolerances.at(x)
        if self.active is None:
            return bool(self._rows.holds(x, tolerance))
        excess = np.abs(self._rows.evaluate(x)) > tolerance
        return not excess[self.active].any()


def _lengths(x: Array, lines: NDArray[np.int64]) -> Array:
    """Of lines by where their ends are in `x`, (k, 4)."""
    a, b, c, d = x[lines].T
    found: Array = np.hypot(c - a, d - b)
    return found


class _Chosen(NamedTuple):
    """Where derivatives of some rows by some unknowns are, to be put into a dense matrix."""

    rows: NDArray[np.int64]
    entries: NDArray[np.int64]
    places: NDArray[np.int64]
    shape: tuple[int, int]


def _chosen(rows: Rows, own: NDArray[np.int64], columns: NDArray[np.int64]) -> _Chosen:
    row_of = np.full(rows.m, -1, dtype=np.int64)
    row_of[own] = np.arange(len(own))
    column_of = np.full(rows.n, -1, dtype=np.int64)
    column_of[columns] = np.arange(len(columns))
    at = row_of[np.repeat(np.arange(rows.m), np.diff(rows.indptr))]
    by = column_of[rows.indices]
    entries = np.flatnonzero((at >= 0) & (by >= 0))
    return _Chosen(own, entries, at[entries] * len(columns) + by[entries], (len(own), len(columns)))


def _pattern(rows: Rows) -> Any:
    """Which unknowns each row reads, (m, n)."""
    # imported here: start-up time
    from scipy.sparse import csr_array

    indices, indptr = rows.indices, rows.indptr
    return csr_array((np.ones(len(indices)), indices, indptr), shape=(rows.m, rows.n))
