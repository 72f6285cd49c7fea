"""Proofs that constraints and dimensions cannot hold together, near to where they are drawn.

A search that finds nothing proves nothing. What proves it is a drawing with the least sum of
squared residuals that is not zero. No step makes that smaller to first order: the residuals are the
multipliers of the equations, and multipliers of sides and lengths at their limits have the right
sign. No step does to second order: curvatures are not negative (J. Nocedal, S. Wright, "Numerical
Optimization", 2nd ed., 2006, theorems 12.1 and 12.5). It is the least sum of several starts.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from arael.sketch.solve.region import Region
from arael.sketch.solve.search import Search
from arael.sketch.solve.solver import Solver

Array = NDArray[np.float64]

#: Unknowns of a proof at most: its matrices are dense.
MOST_UNKNOWNS = 60
#: Residuals, relative to the figure's size, from which on equations are open.
OPEN = 1e-7
#: What may be left of the gradient, relative to the residuals.
STATIONARY = 1e-4
#: Curvature, relative to the largest, below which it is negative.
NEGATIVE = -1e-4
#: Share of what they are now that lengths of lines and numbers of sides keep. Equations of
#: directions are lengths: with less, all of them are nearly fulfilled.
KEPT = 0.5
#: There must be no solution where they may become as short as this, either.
SHORTER = 0.02
#: Evaluations of a minimisation at most: one that has not ended creeps along a valley.
EVALUATIONS = 200
#: Residuals of at least this share of the largest one are not zero where their sum is least.
PULLS = 1e-4
#: Sums that differ by less than this share are the same.
SAME = 1e-4
#: How far starts are from the drawing, relative to the figure's size.
STARTS = (0.0, 0.02, 0.1, 0.3)
#: Steps of a minimisation on all sides: those that end take up to 60; the others creep.
MOST_STEPS = 100
#: Step for curvatures, relative to the figure's size.
STEP = 1e-5


def proven(solver: Solver, names: Sequence[str]) -> bool:
    """Whether these constraints and dimensions are proven to have no common solution near."""
    layout = solver.layout
    x = layout.gather().copy()
    solver.prepare(x)
    region = Region(solver, x, names)
    if not region.is_open:
        # Between points that are held there is nothing to be moved; nor is there anything left of a
        # line whose ends are one place.
        excess = np.abs(layout.rows.evaluate(x)) > OPEN * layout.size
        stuck = bool((excess & solver.rows_of(names)).any()) and not region.is_large
        return stuck or bool(solver.collapsed(x))
    if len(region.columns) > MOST_UNKNOWNS:
        return False
    if Search(solver, x, names).solution() is not None:
        return False
    least = Least(region, x, region.size)
    found = least.lowest(solver)
    if not found or not least.is_minimum(found[0]):
        return False
    shorter = Least(region, x, region.size, SHORTER).lowest(solver)
    return bool(shorter) and least.value(shorter[0]) > OPEN**2


def pulling(solver: Solver, names: Sequence[str]) -> tuple[str, ...]:
    """Those of these that pull against each other where the sum of squared residuals is least."""
    layout, document = solver.layout, solver.layout.document
    x = layout.gather().copy()
    solver.prepare(x)
    region = Region(solver, x, names)
    if not region.is_open or len(region.columns) > MOST_UNKNOWNS:
        return ()
    least = Least(region, x, region.size)
    found = least.lowest(solver)
    if not found:
        return ()
    # Where contradictions can be shared in several ways, one alone may have all of it.
    pulls = np.max([np.abs(least.residuals(z)) for z in found], axis=0)
    rows = region.rows[pulls > PULLS * pulls.max(initial=0.0)]
    owners = dict.fromkeys(layout.owner[row] for row in rows.tolist())
    return tuple(
        name for name in owners if name in document.constraints or name in document.dimensions
    )


class Least:
    """The least sum of squared residuals of a region, with the figure's size as the unit.

    Parameters
    ----------
    region : equations and sides
    x : (n,) unknowns of the layout
    size : of the figure
    kept : share of what they are now that lengths and sides keep
    """

    def __init__(self, region: Region, x: Array, size: float, kept: float = KEPT) -> None:
        self._region, self._x, self._size = region, x, size
        self._limits = kept * region.sides_at(x)[0] / size

    def unknowns(self, x: Array) -> Array:
        """Scaled unknowns of the region."""
        region = self._region
        found: Array = x[region.columns] / (region.scale[region.columns] * self._size)
        return found

    def _at(self, z: Array) -> Array:
        region, x = self._region, self._x.copy()
        x[region.columns] = z * region.scale[region.columns] * self._size
        return np.clip(x, region.low, region.high, out=x)

    def residuals(self, z: Array) -> Array:
        """Of the region's equations."""
        return self._region.residuals(self._at(z)) / self._size

    def _jacobian(self, z: Array) -> Array:
        return self._region.linearised(self._at(z))[1]

    def value(self, z: Array) -> float:
        """Half of the sum of squares."""
        residuals = self.residuals(z)
        return 0.5 * float(residuals @ residuals)

    def _gradient(self, z: Array) -> Array:
        found: Array = self._jacobian(z).T @ self.residuals(z)
        return found

    def _spare(self, z: Array) -> Array:
        """How far sides and lengths are above their limits."""
        found: Array = self._region.sides_at(self._at(z))[0] / self._size - self._limits
        return found

    def _slopes(self, z: Array) -> Array:
        return self._region.sides_at(self._at(z))[1]

    def lowest(self, solver: Solver) -> list[Array]:
        """The lowest of the minima from several starts around the drawing, and those as low."""
        start = self.unknowns(self._x)
        found = []
        for number, far in enumerate(STARTS):
            if solver.interrupted:
                return []
            one = self.minimum(start + far * self._region.nudge(0.25 * number))
            if one is not None:
                found.append(one)
        found.sort(key=self.value)
        return [z for z in found if self.value(z) <= (1.0 + SAME) * self.value(found[0])]

    def minimum(self, start: Array) -> Array | None:
        """Where the sum is least from a start, on all sides; None where that is not found."""
        # imported here: start-up time
        from scipy.optimize import least_squares, minimize

        with np.errstate(all="ignore"):
            try:
                found = least_squares(
                    self.residuals,
                    start,
                    jac=self._jacobian,
                    xtol=1e-14,
                    ftol=1e-14,
                    gtol=1e-14,
                    max_nfev=EVALUATIONS,
                )
                if (self._spare(found.x) >= 0.0).all():
                    return np.asarray(found.x)
                for _ in range(2):  # its Hessian is made anew
                    found = minimize(
                        self.value,
                        start,
                        jac=self._gradient,
                        method="SLSQP",
                        constraints={"type": "ineq", "fun": self._spare, "jac": self._slopes},
                        options={"maxiter": MOST_STEPS, "ftol": 1e-15},
                    )
                    start = found.x
                    if not found.success:  # more of it leads nowhere
                        break
            except (ValueError, np.linalg.LinAlgError):
                return None
            kept = (self._spare(found.x) >= -1e-6).all()
        return np.asarray(found.x) if kept else None

    def is_minimum(self, z: Array) -> bool:
        """Whether neither first nor second derivatives lead to a smaller sum, which is not zero."""
        # imported here: start-up time
        from scipy.optimize import nnls

        residuals, gradient = self.residuals(z), self._gradient(z)
        open_ = float(np.linalg.norm(residuals))
        if not open_ > OPEN:
            return False
        at_limit = self._spare(z) < 1e-6
        slopes = self._slopes(z)[at_limit]
        multipliers, left = nnls(slopes.T, gradient) if len(slopes) else (np.zeros(0), None)
        if left is None:
            left = float(np.linalg.norm(gradient))
        if not left <= STATIONARY * open_:
            return False
        held = slopes[multipliers > STATIONARY * open_]
        _, values, ways = np.linalg.svd(held) if len(held) else (None, (), np.eye(len(z)))
        ways = ways[int(np.count_nonzero(np.asarray(values) > 1e-9)) :]
        curvature = np.empty((len(ways), len(ways)))
        for k, way in enumerate(ways):
            ahead = self._lagrangian(z + STEP * way, at_limit, multipliers)
            behind = self._lagrangian(z - STEP * way, at_limit, multipliers)
            curvature[k] = ways @ (ahead - behind) / (2.0 * STEP)
        found = np.linalg.eigvalsh(0.5 * (curvature + curvature.T))
        return not len(found) or bool(found[0] >= NEGATIVE * max(float(found[-1]), open_))

    def _lagrangian(self, z: Array, at_limit: NDArray[np.bool_], multipliers: Array) -> Array:
        """Gradient of the sum less that of what is held at its limit."""
        found: Array = self._gradient(z) - self._slopes(z)[at_limit].T @ multipliers
        return found
