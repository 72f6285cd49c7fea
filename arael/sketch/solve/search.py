"""Solutions where the step of least norm leads to none: past guards, and from singular starts.

Newton's method ends where a guard stops its step, or where the equations depend on each other,
although freedoms are open. Here a small dense problem around the open equations is solved:

- Guards become inequalities of the step, and so do lengths of lines, which a least step may shrink
  to nothing. What the least step would turn over keeps its extent, and the rest of the change is
  taken by what is free: a least-distance problem (C. Lawson, R. Hanson, "Solving Least Squares
  Problems", 1974, chapter 23).
- Where a combination of equations has no derivative, its curvature moves: along null directions of
  the Jacobian, to both sides.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from arael.sketch.solve.region import MOST_UNKNOWNS, Region

if TYPE_CHECKING:
    from arael.sketch.solve.solver import Solver

Array = NDArray[np.float64]

#: Steps past guards; most searches take fewer than ten.
STEPS = 40
#: Parts of the way of a step, where the sides cannot be kept for all of it.
PARTS = (1.0, 0.5, 0.2, 0.05)
#: Steps after the equations hold.
POLISHING = 3
#: Share of a guard's number that a step may use up.
SHARE = 0.7
#: Singular values below this share of the largest are zero.
_ZERO = 1e-9
#: Nudges from a singular start, as shares of the drawing's size.
NUDGES = (0.02, 0.2)
#: Curved directions that are tried.
MOST_WAYS = 3
#: Curvatures that differ by less than this share of the largest are one.
_ALIKE = 1e-6


class Search:
    """Looks for a solution on the sides of a state, near it.

    Parameters
    ----------
    solver : with the new values set, and prepared
    x : (n,) unknowns of the layout; not changed
    names : constraints and dimensions that count; all without
    most : unknowns at most; the rest does not move
    """

    def __init__(
        self,
        solver: Solver,
        x: Array,
        names: Sequence[str] | None = None,
        most: int = MOST_UNKNOWNS,
    ) -> None:
        self._solver, self._start = solver, x
        self._region = Region(solver, x, names, most)

    def solution(self) -> Array | None:
        """Unknowns that solve everything and keep the sides; None if none was found."""
        if not self._region.is_open:
            return None
        found = self._past_guards()
        if found is not None:
            return found
        return next(self._past_curves(), None)

    def _polished(self, x: Array) -> bool:
        """Solve in place from there; whether that is done."""
        return self._solver.guarded(x, self._region.active)

    def _good(self, x: Array) -> bool:
        """Whether a solution keeps sides and leaves something of everything."""
        return self._region.keeps_sides(x) and not self._solver.collapsed(x)

    # --- past guards ----------------------------------------------------------------------------

    def _past_guards(self) -> Array | None:
        """By steps of least norm among those that keep all sides."""
        x = self._start.copy()
        region = self._region
        columns, scale = region.columns, region.scale[region.columns]
        size = np.inf
        for _ in range(STEPS):
            if self._solver.interrupted:
                return None
            residuals, jacobian = self._region.linearised(x)
            sides, slopes = self._region.sides_at(x)
            least, free = _solve(jacobian, residuals)
            steps = (self._least(part * least, free, sides, slopes, x) for part in PARTS)
            step = next((one for one in steps if one is not None), None)
            if step is None:
                return None
            norm = float(np.linalg.norm(residuals))
            share = 1.0
            while True:
                tried = x.copy()
                tried[columns] += share * scale * step
                np.clip(tried, self._region.low, self._region.high, out=tried)
                new = float(np.linalg.norm(region.residuals(tried)))
                if new < norm * (1.0 - 1e-4 * share) and region.keeps_sides(tried):
                    break
                share *= 0.5
                if share < 1e-4:
                    return None
            x = tried
            if region.holds(x):
                polished = self._to_rounding(x)
                if self._polished(polished):
                    x = polished
                return x if self._good(x) else None
            if new > 0.999 * size:
                return None
            size = new
        return None

    def _to_rounding(self, x: Array) -> Array:
        """A solution by more steps: the rank is judged where equations hold up to rounding."""
        region, columns = self._region, self._region.columns
        for _ in range(POLISHING):
            residuals, jacobian = region.linearised(x)
            tried = x.copy()
            tried[columns] += region.scale[columns] * _solve(jacobian, residuals)[0]
            np.clip(tried, region.low, region.high, out=tried)
            if not np.linalg.norm(region.residuals(tried)) < 0.5 * np.linalg.norm(residuals):
                break
            x = tried
        return x

    def _least(
        self, least: Array, free: Array, sides: Array, slopes: Array, x: Array
    ) -> Array | None:
        """The least scaled step that does as much as the step `least` does, and keeps the sides."""
        scale = self._region.scale[self._region.columns]
        low = self._region.low[self._region.columns] - x[self._region.columns]
        high = self._region.high[self._region.columns] - x[self._region.columns]
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
        size = self._region.size
        for way in self._ways(x):
            for nudge in NUDGES:
                found: list[tuple[float, Array]] = []
                for sign in (1.0, -1.0):
                    if solver.interrupted:
                        return
                    tried = x.copy()
                    tried[self._region.columns] += sign * nudge * size * way
                    np.clip(tried, self._region.low, self._region.high, out=tried)
                    if self._polished(tried) and self._good(tried):
                        distance = float(np.linalg.norm((tried - x) / self._region.scale))
                        found.append((distance, tried))
                if found:
                    # Mirrored solutions are equally far: the first of them.
                    least = min(one[0] for one in found)
                    yield next(y for distance, y in found if distance <= least * (1.0 + 1e-6))
                    return

    def _ways(self, x: Array) -> list[Array]:
        """Unit directions of the chosen unknowns, those that curve most first."""
        residuals, jacobian = self._region.linearised(x)
        least, free = _solve(jacobian, residuals)
        if not free.shape[1]:
            return []
        # The part of the residuals that no step takes away to first order: the multipliers.
        open_ = residuals + jacobian @ least
        if not np.linalg.norm(open_) > 1e-6 * np.linalg.norm(residuals):
            return []
        scale = self._region.scale[self._region.columns]
        h = 1e-4 * self._region.size
        curvature = np.empty((free.shape[1], free.shape[1]))
        for k in range(free.shape[1]):
            ahead, behind = x.copy(), x.copy()
            ahead[self._region.columns] += h * scale * free[:, k]
            behind[self._region.columns] -= h * scale * free[:, k]
            change = self._region.linearised(ahead)[1]
            change -= self._region.linearised(behind)[1]
            curvature[:, k] = free.T @ (open_ @ change) / (2.0 * h)
        values, vectors = np.linalg.eigh(0.5 * (curvature + curvature.T))
        largest = float(np.abs(values).max(initial=0.0))
        curved = np.flatnonzero(values < -1e-6 * largest)
        # Of directions that curve alike any mixture does, and either sign: the choice is the
        # figure's, not that of rounding and axes. To the left of it is up where it lies.
        nudge = self._region.nudge(0.5, least=0.0)
        found = []
        breaks = np.flatnonzero(np.diff(values[curved]) > _ALIKE * largest) + 1
        for alike in np.split(curved, breaks)[:MOST_WAYS]:
            own = free @ vectors[:, alike]
            way = scale * (own @ (own.T @ nudge))
            reach = self._region.reach(way)
            if reach > 0.0:
                found.append(way / reach)
        return found


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
    left = system @ weights - target
    if gap <= 1e-9 or left[-1] == 0.0:
        return None
    step: Array = least - top * free @ (left[:-1] / left[-1])
    return step
