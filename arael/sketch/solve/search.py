"""Solutions where the step of least norm leads to none: past guards, and from singular starts.

Newton's method ends where a guard stops its step, or where the equations depend on each other,
although freedoms are open. Here a small dense problem around the open equations is solved:

- Guards become inequalities of the step. What the least step would turn over keeps its extent, and
  the rest of the change is taken by what is free: a least-distance problem (C. Lawson, R. Hanson,
  "Solving Least Squares Problems", 1974, chapter 23).
- Where a combination of equations has no derivative, its curvature moves: along null directions of
  the Jacobian, to both sides.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from arael.runtime.levels.compiled import Rows
    from arael.sketch.solve.solver import Solver

Array = NDArray[np.float64]

#: Unknowns of the problem, those next to the open equations first: the rest does not move.
MOST_UNKNOWNS = 240
#: Steps past guards; most searches take fewer than ten.
STEPS = 40
#: Share of a guard's number that a step may use up.
SHARE = 0.7
#: Singular values below this share of the largest are zero.
_ZERO = 1e-9
#: Nudges from a singular start, as shares of the drawing's size.
NUDGES = (0.02, 0.2)
#: Curved directions that are tried.
MOST_WAYS = 3


class Search:
    """Looks for a solution on the sides of a state, near it.

    Parameters
    ----------
    solver : with the new values set, and prepared
    x : (n,) unknowns of the layout; not changed
    """

    def __init__(self, solver: Solver, x: Array) -> None:
        self._solver, self._start = solver, x
        layout = solver.layout
        self._rows, self._guards = layout.rows, layout.guards
        low, high = layout.bounds
        self._low = np.full(len(x), -np.inf) if low is None else low
        self._high = np.full(len(x), np.inf) if high is None else high
        scales = solver.levels.scales
        self._scale = np.ones(len(x)) if scales is None else np.asarray(scales)
        # An arc whose sweep or length is asked for may pass half a turn, where its guard is zero.
        asked = self._asked()
        self._kept = np.zeros(self._guards.m, dtype=bool)
        for row in self._guards.instances().tolist():
            sweep = self._guards.struct(row) == "SweepGuard"
            self._kept[row] = not (sweep and layout.guard_owner[row] in asked)
        self._kept &= self._guards.evaluate(x) > 0.0

    def solution(self) -> Array | None:
        """Unknowns that solve everything and keep the sides; None if none was found."""
        if not self._around():
            return None
        found = self._past_guards()
        if found is not None:
            return found
        return next(self._past_curves(), None)

    def _asked(self) -> set[str]:
        """Entities whose sweep or length is not what it is to be."""
        layout = self._solver.layout
        open_ = np.abs(self._rows.evaluate(self._start)) > self._solver.tolerances.at(self._start)
        dimensions = layout.document.dimensions
        found: set[str] = set()
        for name in {layout.owner[row] for row in np.flatnonzero(open_)} & dimensions.keys():
            if dimensions[name].kind in ("sweep", "arc_length"):
                found.update(dimensions[name].args)
        return found

    # --- the problem around the open equations ------------------------------------------------

    def _around(self) -> bool:
        """Choose unknowns and equations around the open ones; whether there are any."""
        rows, x = self._rows, self._start
        residuals = rows.evaluate(x)
        if not np.isfinite(residuals).all() or not len(residuals):
            return False
        pattern, sides = _pattern(rows), _pattern(self._guards)
        near = np.abs(residuals) > self._solver.tolerances.at(x)
        reached = near @ pattern > 0
        if not reached.any() or reached.sum() > MOST_UNKNOWNS:
            return False
        while True:
            wider = reached @ pattern.T > 0, reached @ sides.T > 0
            more = reached | (wider[0] @ pattern > 0) | (wider[1] @ sides > 0)
            if more.sum() == reached.sum() or more.sum() > MOST_UNKNOWNS:
                break
            reached = more
        self._columns = np.flatnonzero(reached)
        self._own = np.flatnonzero(wider[0])
        self._sides = np.flatnonzero(wider[1] & self._kept)
        return True

    def _dense(self, rows: Rows, x: Array, own: NDArray[np.int64]) -> tuple[Array, Array]:
        """Residuals and scaled Jacobian of some rows, by the chosen unknowns."""
        # imported here: start-up time
        from scipy.sparse import csr_array

        residuals, entries = rows.jacobian(x)
        matrix = csr_array((entries, rows.indices, rows.indptr), shape=(rows.m, rows.n))
        found = matrix[own][:, self._columns].toarray() * self._scale[self._columns]
        return residuals[own], found

    def _solved(self, x: Array) -> bool:
        return bool(self._rows.holds(x, self._solver.tolerances.at(x)))

    def _good(self, x: Array) -> bool:
        """Whether a solution keeps sides and leaves something of everything."""
        kept = self._guards.evaluate(x)[self._kept] > 0.0
        return bool(kept.all()) and not self._solver.collapsed(x)

    # --- past guards ----------------------------------------------------------------------------

    def _past_guards(self) -> Array | None:
        """By steps of least norm among those that keep all sides."""
        x = self._start.copy()
        columns, scale = self._columns, self._scale[self._columns]
        if not len(self._sides):
            return None
        size = np.inf
        for _ in range(STEPS):
            if self._solver.interrupted:
                return None
            residuals, jacobian = self._dense(self._rows, x, self._own)
            sides, slopes = self._dense(self._guards, x, self._sides)
            step = self._least(residuals, jacobian, sides, slopes, x)
            if step is None:
                return None
            norm = float(np.linalg.norm(residuals))
            share = 1.0
            while True:
                tried = x.copy()
                tried[columns] += share * scale * step
                np.clip(tried, self._low, self._high, out=tried)
                new = float(np.linalg.norm(self._rows.evaluate(tried)[self._own]))
                held = self._guards.evaluate(tried)[self._sides]
                if new < norm * (1.0 - 1e-4 * share) and (held > 0.0).all():
                    break
                share *= 0.5
                if share < 1e-4:
                    return None
            x = tried
            if self._solved(x):
                polished = x.copy()
                if self._solver.guarded(polished):
                    x = polished
                return x if self._good(x) else None
            if new > 0.999 * size:
                return None
            size = new
        return None

    def _least(
        self, residuals: Array, jacobian: Array, sides: Array, slopes: Array, x: Array
    ) -> Array | None:
        """The least scaled step that solves the linear equations and keeps the sides."""
        least, free = _solve(jacobian, residuals)
        scale = self._scale[self._columns]
        low = self._low[self._columns] - x[self._columns]
        high = self._high[self._columns] - x[self._columns]
        at_low, at_high = np.flatnonzero(np.isfinite(low)), np.flatnonzero(np.isfinite(high))
        unit = np.eye(len(scale))
        rows = np.vstack([slopes, unit[at_low], -unit[at_high]])
        bounds = np.concatenate([low[at_low] / scale[at_low], -high[at_high] / scale[at_high]])
        # What would turn over keeps its extent: else it would shrink step by step. Where the
        # others cannot take the whole change, it shrinks.
        limits = -SHARE * sides
        over: NDArray[np.bool_] = np.zeros(len(sides), dtype=bool)
        for _ in range(len(sides) + 1):
            step = _least_distance(
                least, free, rows, np.concatenate([np.where(over, 0.0, limits), bounds])
            )
            if step is None:
                break
            # With what is held now the rest of the change may turn over others.
            more = (sides + slopes @ step <= 1.01 * (1.0 - SHARE) * sides) & ~over
            if not more.any():
                return step
            over |= more
        return _least_distance(least, free, rows, np.concatenate([limits, bounds]))

    # --- from singular starts -------------------------------------------------------------------

    def _past_curves(self) -> Iterator[Array]:
        """Along null directions in which a combination of equations curves towards zero."""
        solver, x = self._solver, self._start
        size = solver.layout.size
        for way in self._ways(x):
            for nudge in NUDGES:
                found: list[tuple[float, Array]] = []
                for sign in (1.0, -1.0):
                    if solver.interrupted:
                        return
                    tried = x.copy()
                    tried[self._columns] += sign * nudge * size * way
                    np.clip(tried, self._low, self._high, out=tried)
                    if solver.guarded(tried) and self._good(tried):
                        distance = float(np.linalg.norm((tried - x) / self._scale))
                        found.append((distance, tried))
                if found:
                    # Mirrored solutions are equally far: the first of them.
                    least = min(one[0] for one in found)
                    yield next(y for distance, y in found if distance <= least * (1.0 + 1e-6))
                    return

    def _ways(self, x: Array) -> list[Array]:
        """Unit directions of the chosen unknowns, those that curve most first."""
        residuals, jacobian = self._dense(self._rows, x, self._own)
        least, free = _solve(jacobian, residuals)
        if not free.shape[1]:
            return []
        # The part of the residuals that no step takes away to first order: the multipliers.
        open_ = residuals + jacobian @ least
        if not np.linalg.norm(open_) > 1e-6 * np.linalg.norm(residuals):
            return []
        scale = self._scale[self._columns]
        h = 1e-4 * self._solver.layout.size
        curvature = np.empty((free.shape[1], free.shape[1]))
        for k in range(free.shape[1]):
            ahead, behind = x.copy(), x.copy()
            ahead[self._columns] += h * scale * free[:, k]
            behind[self._columns] -= h * scale * free[:, k]
            change = self._dense(self._rows, ahead, self._own)[1]
            change -= self._dense(self._rows, behind, self._own)[1]
            curvature[:, k] = free.T @ (open_ @ change) / (2.0 * h)
        values, vectors = np.linalg.eigh(0.5 * (curvature + curvature.T))
        largest = float(np.abs(values).max(initial=0.0))
        found = []
        for k in np.flatnonzero(values < -1e-6 * largest)[:MOST_WAYS]:
            way = scale * (free @ vectors[:, k])
            way /= np.abs(way).max()
            # The same sign in every run: its first large number is positive.
            first = way[np.flatnonzero(np.abs(way) > 0.5)[0]]
            found.append(way if first > 0.0 else -way)
        return found


def _pattern(rows: Rows) -> Any:
    """Which unknowns each row reads, (m, n)."""
    # imported here: start-up time
    from scipy.sparse import csr_array

    indices, indptr = rows.indices, rows.indptr
    return csr_array((np.ones(len(indices)), indices, indptr), shape=(rows.m, rows.n))


def _solve(jacobian: Array, residuals: Array) -> tuple[Array, Array]:
    """The step of least norm of linear equations, and a basis of what is free, (n, k)."""
    u, s, vt = np.linalg.svd(jacobian, full_matrices=True)
    rank = int(np.count_nonzero(s > _ZERO * s[0])) if len(s) else 0
    step = -(vt[:rank].T @ ((u[:, :rank].T @ residuals) / s[:rank]))
    return step, vt[rank:].T


def _least_distance(least: Array, free: Array, rows: Array, limits: Array) -> Array | None:
    """``least + free @ z`` with the least z for which ``rows @ step >= limits``; None if none."""
    # imported here: start-up time
    from scipy.optimize import nnls

    matrix, right = rows @ free, limits - rows @ least
    sizes = np.linalg.norm(matrix, axis=1)
    fixed = sizes <= 1e-12
    if (right[fixed] > 1e-9 * (1.0 + np.abs(limits[fixed]))).any():
        return None
    matrix, right = matrix[~fixed] / sizes[~fixed, None], right[~fixed] / sizes[~fixed]
    if not (right > 0.0).any():
        return least
    top = float(np.abs(right).max())
    system = np.vstack([matrix.T, right / top])
    target = np.zeros(len(system))
    target[-1] = 1.0
    weights, gap = nnls(system, target)
    if gap <= 1e-9:
        return None
    left = system @ weights - target
    step: Array = least - top * free @ (left[:-1] / left[-1])
    return step
