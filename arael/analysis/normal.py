"""The normal equations of a problem, scaled and factorised, for covariance and rank."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.analysis.bounds import standing_on_bounds
from arael.analysis.jacobian import jacobian
from arael.diagnostics.records import Diagnostic
from arael.runtime.assembly.positions import coordinates
from arael.runtime.constrained.active import acting_rows, add_acting
from arael.runtime.failures import SolveError
from arael.runtime.linear.compiled import SparseSolver
from arael.runtime.problem import Problem

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_DENSE = 400
"""Up to this many scalars all eigenvalues are computed; beyond, only the smallest."""
_ROUNDS = 8
_DAMPING = 1e-9
"""What is added to the scaled diagonal for a step where directions are free."""


class NormalEquations:
    """J'J over all scalars of the system, in f64, its diagonal scaled to 1.

    The scaled unit of a parameter changes the residuals by one sigma in total, so units do not
    matter.

    Parameters
    ----------
    problem : at its current values
    hold_bounds : whether parameters on an active bound are fixed, as in the solver

    Attributes
    ----------
    on_bound : names of the scalars on an active bound, each with the bound in words
    free : (n,) their numbers in the system
    scale : (size,) the unit of each scalar of the system, 1 if no residual depends on it

    Raises
    ------
    SolveError
        E1008: an entry is not finite.
    """

    def __init__(self, problem: Problem, hold_bounds: bool = False) -> None:
        self.problem = problem
        self.free = problem.free
        self.on_bound: dict[str, str] = {}
        pattern = problem.structure.pattern
        self._row, self._column = coordinates(pattern)
        values = _hessian_values(problem, self._row, self._column)
        # What rows that hold exactly determine is not free; see `Covariance` for what it is worth.
        values = add_acting(problem, values)
        lower = self._row >= self._column
        if not np.isfinite(values[lower]).all():
            raise SolveError(
                Diagnostic(
                    "E1008",
                    "the Hessian has entries that are not finite",
                    origin=problem.layout.name,
                    help=("`model.diagnose()` names the residuals they come from",),
                )
            )
        diagonal = np.ones(problem.size)
        at = lower & (self._row == self._column)
        diagonal[self._row[at]] = values[at]
        diagonal[problem.structure.system.held] = 1
        if hold_bounds and problem.box.count:
            gradient = (
                acting_rows(problem).gradient
                if problem.layout.required
                else np.asarray(problem.evaluation.linearised()[1], dtype=np.float64)
            )
            self._hold(standing_on_bounds(problem, gradient, diagonal), values, diagonal)
        self._unit = (diagonal > 0).astype(np.float64)
        self.scale = 1 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
        self._values = values * self.scale[self._row] * self.scale[self._column]

    def _hold(self, found: dict[int, str], values: Floats, diagonal: Floats) -> None:
        """Remove scalars from the system: their rows and columns become those of the identity."""
        held = np.zeros(self.problem.size, dtype=bool)
        held[list(found)] = True
        values[(held[self._row] | held[self._column]) & (self._row != self._column)] = 0
        values[held[self._row] & (self._row == self._column)] = 1
        diagonal[held] = 1
        name_of = self.problem.structure.system.name_of
        free = set(self.free.tolist())
        self.on_bound = {name_of(k): text for k, text in found.items() if k in free}
        self.free = self.free[~held[self.free]]

    @cached_property
    def names(self) -> list[str]:
        """(n,) names of the free scalars."""
        names = self.problem.structure.system.names()
        return [names[k] for k in self.free]

    @property
    def tolerance(self) -> float:
        """Eigenvalue of the scaled matrix below which a direction is free."""
        # Derivatives in single precision have errors of eps, and so have singular values, whose
        # squares these are. J'J itself is summed in f64.
        single = self.problem.layout.precision == "f32"
        epsilon = float(np.finfo(np.float32).eps) ** 2 * 8 if single else np.finfo(np.float64).eps
        return float(max(len(self.free), 1) * epsilon * max(self.largest, 1.0))

    @cached_property
    def dense(self) -> Floats:
        """Scaled J'J over the free scalars, (n, n), without SciPy, which loads slowly."""
        size = self.problem.size
        found = np.zeros((size, size))
        lower = self._row >= self._column
        found[self._row[lower], self._column[lower]] = self._values[lower]
        found += np.tril(found, -1).T
        np.fill_diagonal(found, self._unit)
        kept: Floats = found[np.ix_(self.free, self.free)]
        return kept

    @cached_property
    def matrix(self) -> Any:
        """Scaled J'J over the free scalars, scipy sparse, CSR, both triangles."""
        # imported here: start-up time
        from scipy.sparse import coo_array

        row, column, values = self._row, self._column, self._values
        below = (row > column) & (values != 0)
        size = self.problem.size
        every = np.arange(size)
        both = coo_array(
            (
                np.concatenate([values[below], values[below], self._unit]),
                (
                    np.concatenate([row[below], column[below], every]),
                    np.concatenate([column[below], row[below], every]),
                ),
            ),
            shape=(size, size),
        ).tocsr()
        return both[self.free][:, self.free]

    @cached_property
    def solver(self) -> SparseSolver:
        """The scaled matrix over the whole system, factorised; see `factorised`."""
        return self.factorised(np.zeros(0, dtype=np.int64))

    def factorised(self, held: Ints) -> SparseSolver:
        """The scaled matrix with the rows and columns of some more scalars those of the identity.

        Parameters
        ----------
        held : numbers of scalars in the system

        Raises
        ------
        SolveError
            E1008: it is singular to rounding.
        """
        values = self._values
        if len(held):
            rests = np.zeros(self.problem.size, dtype=bool)
            rests[held] = True
            apart = (rests[self._row] | rests[self._column]) & (self._row != self._column)
            values = np.where(apart, 0.0, values)
        solver = SparseSolver(self.problem.structure.pattern)
        failed = solver.factorise(values, self._unit)
        if failed:
            raise SolveError(
                Diagnostic(
                    "E1008",
                    f"the system is singular to rounding near "
                    f"`{self.problem.structure.system.name_of(failed - 1)}`",
                    origin=self.problem.layout.name,
                    help=("add measurements, or fix a parameter",),
                )
            )
        return solver

    def covariance(self) -> tuple[Floats, Floats]:
        """Pseudo-inverse (n, n) of J'J, and standard deviations (n,), infinite where it is free."""
        values, vectors = np.linalg.eigh(self.dense)
        scale = self.scale[self.free]
        loose = values <= self.tolerance
        kept = vectors[:, ~loose] / np.sqrt(values[~loose])
        inverse = (kept @ kept.T) * scale[:, None] * scale
        sigma = np.sqrt(np.diag(inverse))
        sigma[np.linalg.norm(vectors[:, loose], axis=1) > 1e-6] = np.inf
        return inverse, sigma

    def damped(self) -> SparseSolver:
        """The scaled matrix, hardly damped, factorised: also where directions are free."""
        solver = SparseSolver(self.problem.structure.pattern)
        damping = _DAMPING
        while solver.factorise(self._values, self._unit + damping):
            damping *= 10
        return solver

    def newton_step(self) -> Floats:
        """(size,) Gauss-Newton step of what is free, hardly damped."""
        solver = self.damped()
        whole = np.zeros(self.problem.size)
        half = np.asarray(self.problem.evaluation.linearised()[1], dtype=np.float64)
        whole[self.free] = -half[self.free] * self.scale[self.free]
        found: Floats = np.asarray(solver.solved(whole)) * self.scale
        return found

    def smallest(self) -> tuple[Floats, Floats]:
        """The smallest eigenvalues of the scaled matrix, and the free directions.

        Returns
        -------
        values : ascending; at least the smallest one that is not free, if there is any
        free : (n, f) orthonormal eigenvectors of those within `tolerance`, over the free scalars
        """
        values, vectors = self._spectrum
        return values, vectors[:, : int(np.count_nonzero(values <= self.tolerance))]

    @cached_property
    def _spectrum(self) -> tuple[Floats, Floats]:
        n = len(self.free)
        if n <= _DENSE:
            values, vectors = np.linalg.eigh(self.dense)
            return values, vectors
        count = 12
        while True:
            values, vectors = self._inverse_iteration(min(count, n))
            if values[-1] > self.tolerance or count >= n:
                return values, vectors
            count *= 4

    def _inverse_iteration(self, count: int) -> tuple[Floats, Floats]:
        """The `count` smallest eigenpairs, by subspace iteration with the shifted inverse."""
        solver = SparseSolver(self.problem.structure.pattern)
        shift = self.tolerance
        while solver.factorise(self._values, self._unit + shift):
            shift *= 10
            if shift > 1:
                break
        basis = np.random.default_rng(0).standard_normal((len(self.free), count))
        for _ in range(_ROUNDS):
            whole = np.zeros((self.problem.size, count))
            whole[self.free] = basis
            basis = np.linalg.qr(solver.solved(whole)[self.free])[0]
        values, turn = np.linalg.eigh(basis.T @ (self.matrix @ basis))
        return values, basis @ turn

    @cached_property
    def largest(self) -> float:
        """The largest eigenvalue, to a few per cent."""
        n = len(self.free)
        if not n:
            return 0.0
        if n <= _DENSE:
            return float(np.linalg.eigvalsh(self.dense)[-1])
        vector = np.random.default_rng(0).standard_normal(n)
        for _ in range(20):
            vector = self.matrix @ (vector / np.linalg.norm(vector))
        return float(np.linalg.norm(vector))


def _hessian_values(problem: Problem, row: Ints, column: Ints) -> Floats:
    """J'J at every entry of the pattern, f64."""
    if problem.layout.precision == "f64":
        return np.asarray(problem.evaluation.linearised()[2], dtype=np.float64)[: len(row)]
    # In f32 the sums would have larger errors than the derivatives.

    matrix = jacobian(problem).matrix
    square = (matrix.T @ matrix).tocsr()
    number = np.full(problem.size, -1, dtype=np.int64)
    number[problem.free] = np.arange(len(problem.free))
    i, j = number[row], number[column]
    moves = (i >= 0) & (j >= 0)
    values = np.where(row == column, 1.0, 0.0)
    values[moves] = np.asarray(square[i[moves], j[moves]]).ravel()
    return values
