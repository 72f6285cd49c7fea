"""The linear solver of small systems, which is chosen without an analysis.

Orderings, symbolic factors and predicted costs of all solvers take milliseconds. A dense
factorisation of `SMALL` unknowns takes three microseconds: hundreds of factorisations would not win
back what choosing takes.
This module imports none of what the analysis needs.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.linear.compiled import DenseSolver, LinearSolver
from arael.runtime.linear.price import Cost, dense_cost

#: Unknowns up to which `auto` takes the dense solver.
SMALL = 64


def small_solver(
    name: str, pattern: BlockPattern, single: bool, options: Mapping[str, Any]
) -> LinearSolver | None:
    """The dense solver where `auto` takes it without an analysis, else None.

    With options the general way is taken, which checks and reports them.
    """
    if name != "auto" or options or pattern.size > SMALL:
        return None
    solver = DenseSolver(pattern, single)
    cost, why = _reason(pattern.size, single)
    solver.plan.update(
        asked=name,
        why=why,
        precision="f32" if single else "f64",
        predicted_ms=cost.milliseconds,
        orderings={},
        costs={"dense": cost.as_dict()},
    )
    return solver


@lru_cache(maxsize=2 * SMALL)
def _reason(size: int, single: bool) -> tuple[Cost, str]:
    """The price of so many unknowns, and why the dense solver is taken."""
    cost = dense_cost(size, single)
    return cost, (
        f"dense is predicted to factorise {size} unknown{'' if size == 1 else 's'} in "
        f"{cost.milliseconds:.3g} ms; up to {SMALL} unknowns it is taken without comparing others, "
        "which would take longer than it"
    )
