"""Which rows act at a solution, and how strongly, from the state alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from arael.runtime.constrained.rows import Bools, Floats, Rows, rows_of
from arael.runtime.problem import Problem

# A row stands at its limit when it is closer to it than this, relative to its scale.
AT_LIMIT = 1e-6
# A multiplier counts from this on, relative to the largest part of the gradient that it balances.
STRONG = 1e-8


@dataclass(frozen=True)
class Acting:
    """Rows that hold the solution: equalities, and inequalities with a multiplier.

    Attributes
    ----------
    rows : all rows
    entries : their derivatives
    strong : (rows,) whether a row acts
    gradient : (size,) J'r less what the rows of the model balance, bounds excepted
    """

    rows: Rows
    entries: Floats
    strong: Bools
    gradient: Floats

    def matrix(self) -> Floats:
        """(acting, size) derivatives of the rows that act, dense."""
        found = np.zeros((self.rows.count, self.rows.size))
        np.add.at(found, (self.rows.row, self.rows.column), self.entries)
        return found[self.strong]


def acting_rows(problem: Problem, bounds: bool = True) -> Acting:
    """The rows that act at the accepted state, which is taken for a solution.

    Multipliers are the non-negative least-squares solution of ``A'y = g`` over the rows that stand
    at their limits.

    Parameters
    ----------
    bounds : whether bounds of parameters are among them
    """
    rows = Rows(problem, bounds=bounds)
    values, entries = rows.evaluate()
    sizes = rows.sizes()
    typical = float(sizes.max(initial=0.0)) or 1.0
    scale = rows.lengths(entries, np.maximum(sizes, 1e-3 * typical))
    equal = rows.equal.astype(bool)
    at_limit = equal | (values <= AT_LIMIT * np.maximum(scale, 1e-300))
    strong = equal.copy()
    _, gradient, hessian = problem.evaluation.linearised()
    gradient = np.array(gradient, dtype=np.float64)
    if at_limit.any():
        diagonal = np.asarray(hessian, dtype=np.float64)[problem.diagonal_at]
        root = np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
        matrix = Acting(rows, entries, at_limit, gradient).matrix()
        y = np.zeros(rows.count)
        y[at_limit] = _multipliers((matrix / root).T, gradient / root, equal[at_limit])
        forces = np.abs(y[at_limit]) * np.linalg.norm(matrix / root, axis=1)
        least = STRONG * max(float(forces.max(initial=0.0)), 1e-300)
        strong[np.flatnonzero(at_limit)[forces > least]] = True
        y[rows.group_rows :] = 0.0
        gradient -= rows.transposed(entries, y)
    return Acting(rows, entries, strong, gradient)


def _multipliers(columns: Floats, target: Floats, equal: Bools) -> Floats:
    # Imported here for start-up time: most models require nothing.
    from scipy.optimize import lsq_linear

    low = np.where(equal, -np.inf, 0.0)
    found: Floats = lsq_linear(columns, target, (low, np.inf), tol=1e-14).x
    return found


def add_acting(problem: Problem, values: Floats, solved: bool = False) -> Floats:
    """Blocks of J'J, with the squares of the rows that act in its metric: what they hold counts.

    Every row gets the information of the cost along it, so that no scale enters.

    Parameters
    ----------
    solved : whether the accepted state is the end of a solve, whose multipliers are known
    """
    if not problem.layout.required:
        return values
    diagonal = np.asarray(values[problem.diagonal_at], dtype=np.float64)
    largest = float(diagonal.max(initial=0.0)) or 1.0
    metric = np.where(diagonal > 1e-12 * largest, diagonal, largest)
    if solved:
        rows = rows_of(problem)
        _, entries = rows.evaluate()
        strong = rows.equal > 0
    else:
        acting = acting_rows(problem, bounds=False)
        rows, entries, strong = acting.rows, acting.entries, acting.strong
    along = rows.lengths(entries, np.sqrt(metric))
    if solved:
        forces = rows.multipliers * along
        strong |= forces > STRONG * max(float(np.abs(forces).max(initial=0.0)), 1e-300)
        strong[rows.group_rows :] = False
    lengths = np.where(along > 0, rows.lengths(entries, np.ones(problem.size)), 1.0)
    weights = np.where(strong, (along / lengths) ** 2 / lengths**2, 0.0)
    found: Floats = values[: problem.structure.pattern.value_count] + rows.squared(entries, weights)
    return found
