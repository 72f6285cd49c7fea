"""A minimal set of rows that cannot hold together, where a problem is infeasible."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from arael.config import LmConfig
from arael.runtime.constrained.compiled import Exact
from arael.runtime.constrained.rows import Rows
from arael.runtime.linear.compiled import LinearSolver
from arael.runtime.problem import Problem

# More violated instances than this are not tried one by one.
MAX_TRIED = 60
# Attempts of one trial.
MAX_ATTEMPTS = 100


def conflict_of(
    problem: Problem, rows: Rows, solver: LinearSolver, config: LmConfig, loop: Exact
) -> tuple[str, ...]:
    """Names of rows that cannot hold together, though all but any one of them can.

    At a minimum of the squared violations only rows that are violated pull, so those alone
    contradict each other there. They are left out one by one, the least violated first: what the
    others do not need to contradict each other stays out (J. Chinneck, "Feasibility and
    Infeasibility in Optimization", 2008, section 6.2, deletion filter). Trials start at the
    minimum; the accepted state of the problem stays there.
    """
    values, _ = rows.evaluate()
    known: dict[str, int] = {}
    unit = np.array([known.setdefault(rows.name(k), len(known)) for k in range(rows.count)])
    names = list(known)
    worst = np.zeros(len(names))
    np.maximum.at(worst, unit, rows.violations(values) / loop.tolerance)
    chosen = np.flatnonzero(worst > 1.0)
    chosen = chosen[np.argsort(worst[chosen], kind="stable")]
    kept = np.zeros(len(names), dtype=bool)
    kept[chosen] = True
    if len(chosen) > MAX_TRIED:
        return tuple(names[int(k)] for k in np.flatnonzero(kept))
    settings = replace(
        config, max_iters=MAX_ATTEMPTS, cost_threshold=0.0, time_limit=None, observer=None
    )
    saved = [np.array(state) for state in problem.states]
    for one in chosen:
        kept[one] = False
        trial = Exact(problem.evaluation, rows, solver, settings, None, False)
        if trial.can_hold(kept[unit].astype(np.float64), loop.scale):
            kept[one] = True
        for number, entity in enumerate(problem.layout.entities):
            stored = saved[number][: len(problem.structure.system.blocks[number].free)]
            problem.evaluation.start_at(number, stored[:, : entity.stored])
    return tuple(names[int(k)] for k in np.flatnonzero(kept))
