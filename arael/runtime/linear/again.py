"""A solver for a pattern that has changed a little: as the one before, without comparing others.

A row appended to a large problem couples two more blocks, or adds one. What suits the problem
stays what it was, so only the chosen ordering and symbolic factor are computed. When the problem
has grown, or a factorisation is predicted to take longer than what was compared, all solvers are
compared again.
"""

from __future__ import annotations

from dataclasses import dataclass

from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.linear.compiled import LinearSolver

# Unknowns and predicted time may differ so much from those of the comparison.
_SIZE = 1.25
_TIME = 1.5


@dataclass(frozen=True)
class Choice:
    """What `auto` took when it compared all solvers.

    Attributes
    ----------
    name : the solver
    ordering : of `sparse`, else ""
    unknowns, milliseconds : size of the system, and predicted time of a factorisation
    """

    name: str
    ordering: str
    unknowns: int
    milliseconds: float

    @classmethod
    def of(cls, solver: LinearSolver) -> Choice | None:
        """The choice behind a solver; None where it was not compared, or is not made again."""
        plan = solver.plan
        if plan.get("asked") != "auto" or plan.get("solver") not in ("band", "sparse"):
            return None
        # Imported here for start-up time: a solve of a small problem does not load the analysis.
        from arael.runtime.linear.analysis import ORDERINGS

        if plan["solver"] == "sparse" and plan.get("ordering") not in ORDERINGS:
            return None
        return cls(plan["solver"], plan.get("ordering", ""), plan["n"], float(plan["predicted_ms"]))

    def made_again(self, pattern: BlockPattern, single: bool) -> LinearSolver | None:
        """A solver of this choice for another pattern; None if all are to be compared."""
        if not self.unknowns / _SIZE <= pattern.size <= self.unknowns * _SIZE:
            return None
        # Imported here for start-up time: a program loads only the solver that it uses.
        from arael.runtime.linear.analysis import analyse
        from arael.runtime.linear.costs import band_cost, sparse_cost

        solver: LinearSolver
        if self.name == "band":
            from arael.runtime.linear.compiled import BandSolver

            cost = band_cost(pattern, single)
            if cost.milliseconds > self._most():
                return None
            solver = BandSolver(pattern, single)
        else:
            from arael.runtime.linear.compiled import SparseSolver

            analysis = analyse(pattern, self.ordering)
            cost = sparse_cost(single, analysis)
            if cost.milliseconds > self._most():
                return None
            solver = SparseSolver(pattern, single, analysis=analysis)
        solver.plan.update(
            asked="auto",
            why=f"{self.name} was chosen for {self.unknowns} unknowns earlier in this session, and "
            f"is predicted to factorise {pattern.size} in {cost.milliseconds:.3g} ms",
            precision="f32" if single else "f64",
            predicted_ms=cost.milliseconds,
            orderings={self.ordering: cost.flops} if self.ordering else {},
            costs={self.name: cost.as_dict()},
        )
        return solver

    def _most(self) -> float:
        """Predicted milliseconds up to which the choice stands."""
        return _TIME * self.milliseconds
