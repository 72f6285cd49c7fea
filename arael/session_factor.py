"""Marginals and products with the inverse after a solve, in the memory of its linear solver.

A covariance of its own analyses the system, asks eigenvalues and allocates a factor: a hundred
milliseconds for thousands of unknowns. Right after a solve the session has all of it. J'J at the
solution is factorised in the memory of the solver, without damping (the solve's own factor is that
of a state before its last step), and the marginal of a few scalars E is a forward sweep for each:

    (J'J)^-1 = L^-T L^-1,    C_E = Y'Y,    Y = L^-1 E

The next solve takes the memory back; a covariance that is asked afterwards factorises itself.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.notes import has_symmetries
from arael.runtime.linear.compiled import LinearSolver, SparseSolver
from arael.runtime.problem import Problem
from arael.session import Session, session_of

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class SessionFactor:
    """The factor of a problem at its values, until the session is used for something else.

    Attributes
    ----------
    stamp : the number of the use of the session's solver that made it
    """

    session: Session
    solver: LinearSolver
    stamp: int

    def marginal(self, scalars: Ints) -> Floats | None:
        """(k, k) block of the inverse for scalars of the system; None if there is no factor now."""
        with self.session.held() as session:
            if session is not self.session or session.stamp != self.stamp:
                return None
            unit = np.zeros((self.solver.n, len(scalars)), order="F")
            unit[scalars, np.arange(len(scalars))] = 1
            if not isinstance(self.solver, SparseSolver):
                return np.asarray(self.solver.solved(unit))[scalars]
            if session.swept is None or session.swept[0] is not self.solver:
                session.swept = (self.solver, _places_of_y(self.solver))
            storage, places = self.solver.parts()[1], session.swept[1]
            y = np.empty((len(scalars), len(places)))
            for k in range(len(scalars)):
                self.solver.forward(unit[:, k])
                y[k] = storage[places]
        return y @ y.T

    def solved(self, right: Floats) -> Floats | None:
        """(n,) or (n, k) ``(J'J)^-1 right`` over the system; None if there is no factor now."""
        with self.session.held() as session:
            if session is not self.session or session.stamp != self.stamp:
                return None
            return np.array(self.solver.solved(right), dtype=np.float64)


def session_factor(model: Any, problem: Problem) -> SessionFactor | None:
    """The factor of a problem of a model at its present values; None if it takes more.

    After a solve in f64 without bounds, of the same structure, that found nothing free.
    """
    session = session_of(model)
    system = problem.structure.system
    if (
        problem.layout.precision != "f64"
        or problem.box.count
        or problem.hooks is not None
        or session.structural is None
        or session.structural[0] is not problem.structure
        or any(note.topic in ("free", "underdetermined") for note in session.structural[1])
    ):
        return None
    with session.held() as held:
        solver = held.solver
        if held is not session or solver is None or solver.plan.get("solver") == "schur_pcg":
            return None
        if not held.determined:
            # Once: what holds the map holds it when rows are added.
            held.determined = not has_symmetries(problem)
            if not held.determined:
                return None
        values = np.asarray(problem.evaluation.linearised()[2])[: solver.pattern.value_count]
        diagonal = values[problem.diagonal_at]
        diagonal[system.held] = 1
        held.stamp += 1
        if not np.isfinite(diagonal).all() or solver.factorise(values, diagonal):
            return None
        return SessionFactor(held, solver, held.stamp)


def _places_of_y(solver: SparseSolver) -> Ints:
    """(n,) where the forward sweep leaves y in the storage: behind the rows of each panel."""
    table = solver.parts()[0][1:]
    columns, below, low, panel = (table[:, k].astype(np.int64) for k in (0, 1, 3, 6))
    start = np.repeat(panel + below, columns)
    ends = np.cumsum(columns)
    within = np.arange(int(ends[-1])) - np.repeat(ends - columns, columns)
    return np.asarray(start + np.repeat(low, columns) * within)
