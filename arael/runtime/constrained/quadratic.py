"""The step of a solve with exact rows: a convex quadratic problem, solved to rounding.

    min  d'H d / 2 + g'd   with   c + A d = 0 for equalities, c + A d >= 0 for inequalities

By the proximal method of multipliers: for estimates y of the multipliers, the augmented Lagrangian

    d'H d / 2 + g'd + sum_i (max(0, y_i - w_i t_i)^2 / (2 w_i)),   t = c + A d

(equalities without the max) is minimised by Newton's method with an exact line search, which ends
after finitely many steps because the function is piecewise quadratic; then ``y = max(0, y - w t)``.
Each Newton step is one factorisation of ``H + A_W' w A_W`` on the blocks of the model, where W are
the rows in use: the Schur complement of the quasi-definite system ``[H A'; A -1/w]``. With weights
of 1e7 times the curvature of the cost along a row two rounds reach rounding level, and both need
the same factor. R. Rockafellar, Math. Oper. Res. 1, 1976; A. De Marchi, Comput. Optim. Appl. 81,
2022; A. Bambade et al., "PROX-QP", RSS 2022.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from arael.runtime.constrained.limits import Limits
from arael.runtime.constrained.rows import Bools, Floats
from arael.runtime.linear.compiled import LinearSolver

# Weight of a row relative to the curvature of the cost along it. Below 1e5 more rounds are needed,
# beyond 1e10 rounding of the factor shows in steps along the rows.
WEIGHT = 1e7
MAX_NEWTON = 60  # of one round
MAX_ROUNDS = 12
# Rows hold when they are violated by less than this, relative to what they were before.
HELD = 1e-12


@dataclass
class Step:
    """Solution of the quadratic problem.

    Attributes
    ----------
    step : (n,) d
    multipliers : (rows,) y
    holds : whether the linear rows can hold, and do
    factorisations : number of them
    """

    step: Floats
    multipliers: Floats
    holds: bool
    factorisations: int


class Quadratic:
    """The quadratic problem at one linearisation.

    Parameters
    ----------
    limits, entries : the rows, and their derivatives
    values, diagonal : H, damping included
    gradient : g
    weights : (rows,) w
    """

    def __init__(
        self,
        limits: Limits,
        solver: LinearSolver,
        entries: Floats,
        values: Floats,
        diagonal: Floats,
        gradient: Floats,
        weights: Floats,
    ) -> None:
        self.limits, self.solver, self.entries = limits, solver, entries
        self.values, self.diagonal, self.gradient = values, diagonal, gradient
        self.weights = weights
        self.factored: Bools | None = None
        self.factorisations = 0

    def solve(self, rows: Floats, multipliers: Floats, tolerance: Floats) -> Step | None:
        """The step; None if the matrix is not positive definite.

        Parameters
        ----------
        rows : (rows,) c
        multipliers : (rows,) estimates to begin with
        tolerance : (rows,) violations of the linear rows that count as none; a hundredth of it is
            aimed at
        """
        y = multipliers
        d: Floats | None = None
        equal, weights = self.limits.equal, np.maximum(self.weights, 1e-300)
        holds = False
        # Rows that were in use, also where a step along them has left them by its curvature.
        active = equal | (y > 0.0) | (rows < 0.0)
        before = np.inf
        for _ in range(MAX_ROUNDS):
            found = self._minimum(rows, y, d, active)
            if found is None:
                return None
            d, t, active = found
            pull = y - weights * t
            y = np.where(equal, pull, np.maximum(0.0, pull))
            # Distance from the rows; of an inequality also of its multiplier from being needless.
            apart = np.where(equal, np.abs(t), np.abs(np.minimum(t, y / weights)))
            ratio = float((apart / tolerance).max(initial=0.0))
            holds = bool((self.limits.violations(t) <= tolerance).all())
            if ratio <= 0.01:
                break
            if ratio > 0.7 * before:  # rows contradict each other, or depend on each other
                break
            before = ratio
        assert d is not None
        return Step(d, y, holds, self.factorisations)

    def minimum(self, rows: Floats, multipliers: Floats) -> tuple[Floats, Floats] | None:
        """The step that makes the augmented Lagrangian least, and the rows there."""
        active = self.limits.equal | (rows < 0.0)
        found = self._minimum(rows, multipliers, None, active)
        return None if found is None else found[:2]

    def _active(self, t: Floats, y: Floats) -> Bools:
        return self.limits.equal | (y > self.weights * t)

    def _minimum(
        self, rows: Floats, y: Floats, d: Floats | None, active: Bools
    ) -> tuple[Floats, Floats, Bools] | None:
        """Minimum of the augmented Lagrangian: d, t and the rows in use; None as of `solve`.

        Steps are solved for as increments, so that rounding errors of an ill-conditioned factor
        shrink with them.
        """
        limits, weights = self.limits, self.weights
        first = d is None
        d = np.zeros_like(self.gradient) if d is None else d
        t = rows + limits.times(self.entries, d)
        for _ in range(MAX_NEWTON):
            if not self._factor(active):
                return None
            pull = np.where(active, y - weights * t, 0.0)
            force = limits.transposed(self.entries, pull) - self.gradient
            if not first:
                force -= self._hessian(d)
            along: Floats = np.asarray(self.solver.solved(force), dtype=np.float64)
            d = d + (along if first else self._length(t, y, d, along) * along)
            first = False
            t = rows + limits.times(self.entries, d)
            now = self._active(t, y)
            if np.array_equal(now, active):
                return d, t, active
            active = now
        return d, t, active

    def _factor(self, active: Bools) -> bool:
        if self.factored is not None and np.array_equal(active, self.factored):
            return True
        values, diagonal = self.values.copy(), self.diagonal.copy()
        self.limits.add_squares(self.entries, np.where(active, self.weights, 0.0), values, diagonal)
        self.factorisations += 1
        if self.solver.factorise(values, diagonal) != 0:
            self.factored = None
            return False
        self.factored = active
        return True

    def _length(self, t: Floats, y: Floats, d: Floats, along: Floats) -> float:
        """The minimum of the augmented Lagrangian along a direction: piecewise quadratic."""
        limits, weights, equal = self.limits, self.weights, self.limits.equal
        slope = limits.times(self.entries, along)
        h_d, h_along = self._hessian(d), self._hessian(along)
        constant = float(along @ (h_d + self.gradient))
        growth = float(along @ h_along)

        def derivative(length: float) -> float:
            pull = y - weights * (t + length * slope)
            pull = np.where(equal, pull, np.maximum(0.0, pull))
            return constant + length * growth - float(pull @ slope)

        if derivative(1.0) <= 0.0:
            return 1.0
        with np.errstate(divide="ignore", invalid="ignore"):
            kinks = (y / weights - t) / slope
        kinks = np.sort(kinks[~equal & (weights > 0.0) & (kinks > 0.0) & (kinks < 1.0)])
        low, high = 0.0, 1.0
        first, last = 0, len(kinks)
        while first < last:  # the piece on which the derivative changes its sign
            middle = (first + last) // 2
            if derivative(float(kinks[middle])) <= 0.0:
                low, first = float(kinks[middle]), middle + 1
            else:
                high, last = float(kinks[middle]), middle
        a, b = derivative(low), derivative(high)
        return low if b <= a else low - a * (high - low) / (b - a)

    def _hessian(self, x: Floats) -> Floats:
        return self.limits.product(self.values, self.diagonal, x)
