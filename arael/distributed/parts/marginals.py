"""Covariance of entities from the factors of the parts."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arael.analysis.bounds import standing_on_bounds
from arael.diagnostics.records import AraelError, Diagnostic
from arael.distributed.parts.team import Team
from arael.runtime.failures import SolveError
from arael.runtime.problem import Problem
from arael.runtime.system import row_name

Floats = NDArray[np.float64]


class PartCovariance:
    """Marginal covariances at the solution, ``(J'J)^-1`` for whitened residuals.

    Scalars on an active bound are not free: they have no variance, as on one machine.

    The undamped matrix is factorised once, in parts. A marginal takes a sweep of the part that has
    the entity, a solution of the boundary system and a sweep back, for each scalar.

    Raises
    ------
    SolveError
        E1008: the system is singular.
    """

    def __init__(self, problem: Problem, team: Team) -> None:
        self._problem, self._team = problem, team
        team.choose(None)
        _, gradient, diagonal = team.linearise(problem.states)
        diagonal = diagonal.copy()
        diagonal[problem.structure.system.held] = 1
        on_bounds = list(standing_on_bounds(problem, gradient, diagonal))
        team.hold(np.array(on_bounds, dtype=np.int64))
        diagonal[on_bounds] = 1
        self._free = np.ones(problem.size, dtype=bool)
        self._free[on_bounds] = False
        failed, _ = team.factor(diagonal, np.zeros(problem.size))
        if failed:
            raise SolveError(
                Diagnostic(
                    "E1008",
                    "the system is singular: "
                    f"`{problem.structure.system.name_of(failed - 1)}` is not determined by the "
                    "constraints",
                    origin=problem.layout.name,
                    help=("hold what the constraints leave free, for example the first pose",),
                )
            )

    def marginal(self, collection: str, row: int) -> Floats:
        """(k, k) covariance of the free scalars of a row; "" and 0 for those of the root.

        Raises
        ------
        AraelError
            E1009: no such row, or nothing of it moves.
        """
        scalars = self._scalars(collection, row)
        return self._team.inverse(scalars)

    def names(self, collection: str, row: int) -> list[str]:
        """(k,) names of the scalars of `marginal`."""
        system = self._problem.structure.system
        return [system.name_of(int(i)) for i in self._scalars(collection, row)]

    def _scalars(self, collection: str, row: int) -> NDArray[np.int64]:
        system = self._problem.structure.system
        found = [np.zeros(0, dtype=np.int64)]
        known = collection in self._problem.store.tables
        size = self._problem.store.tables[collection].size if known else 0
        for entity, blocks in zip(self._problem.layout.entities, system.blocks, strict=True):
            if entity.table != collection or not 0 <= row < size or blocks.first[row] < 0:
                continue
            found.append(blocks.first[row] + np.flatnonzero(blocks.free[row]))
        scalars = np.concatenate(found)
        scalars = scalars[self._free[scalars]]
        if not len(scalars):
            what = (
                f"`{row_name(self._problem.store, collection, row)}` has no free parameter"
                if 0 <= row < size
                else f"there is no row {row} of `{collection}`"
            )
            raise AraelError(
                Diagnostic(
                    "E1009", what, origin="covariance", help=("name a row that is solved for",)
                )
            )
        return scalars
