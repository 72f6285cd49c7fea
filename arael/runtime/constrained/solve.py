"""One solve with exact rows, from its stored start to the accepted end."""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from arael.config import LmConfig
from arael.runtime.constrained.conflict import conflict_of
from arael.runtime.constrained.limits import limits_of
from arael.runtime.constrained.loop import Loop
from arael.runtime.constrained.required import Required, Requirement
from arael.runtime.levenberg.compiled import RECORD
from arael.runtime.levenberg.trace import Watcher
from arael.runtime.linear.auto import make_solver
from arael.runtime.linear.compiled import LinearSolver
from arael.runtime.parallel.compiled import threads_for
from arael.runtime.problem import Problem
from arael.runtime.solve import Outcome


def minimise_exactly(
    problem: Problem,
    config: LmConfig,
    solver: LinearSolver,
    write: Callable[[str], object] | None,
    analysis_seconds: float,
) -> Outcome:
    """Solve a problem whose model has rows that hold exactly; as `arael.runtime.solve.minimise`."""
    began = time.perf_counter()
    threads = threads_for(config.num_threads)
    problem.evaluation.threads = threads
    solver.use_threads(threads)
    problem.check_start()
    problem.state_dirty = True
    limits = limits_of(problem)
    if solver.single or solver.plan.get("solver") == "schur_pcg":
        # Rows are weighted by more than single precision, or approximate steps, resolve.
        solver = make_solver("auto", problem.structure.pattern, False)
        solver.use_threads(threads)
    watcher = Watcher(problem, write, config.observer, True)
    loop = Loop(problem, limits, solver, config)
    if watcher.watches:
        loop.stepped = lambda record: watcher.stepped(loop, record)
    try:
        status = loop.run()
    except KeyboardInterrupt:
        status = "aborted"
    conflict: tuple[str, ...] = ()
    if status == "infeasible":
        conflict = conflict_of(loop)
        limits.settle(loop.multipliers, np.zeros(limits.count))
    total = time.perf_counter() - began + problem.seconds + analysis_seconds
    timing = {"prepare": problem.seconds, "analyse": analysis_seconds, "total": total}
    return Outcome(
        problem.x,
        loop.start_cost,
        problem.cost(),
        loop.attempts,
        loop.accepted,
        status,
        loop.damping,
        solver.report(),
        timing,
        np.array(loop.records, dtype=RECORD),
        np.nan,
        np.nan,
        np.nan,
        required=required_of(loop, conflict),
    )


def required_of(loop: Loop, conflict: tuple[str, ...] = ()) -> Required:
    """What became of the rows, at the accepted state."""
    limits = loop.limits
    values, _ = limits.evaluate()
    violations = limits.violations(values) / np.maximum(loop.scale, 1e-300)
    at = int(violations.argmax()) if len(violations) else -1
    # Of the cost, without the factor 1/2; of an equality what the cost falls by where the right
    # side grows.
    multipliers = 2.0 * np.where(limits.equal, -loop.multipliers, loop.multipliers)
    active = limits.equal | (np.abs(values) <= 1e3 * loop.tolerances.rows * loop.scale)
    rows, problem = limits.rows, loop.problem
    groups = problem.layout.groups
    parts = []
    for label in dict.fromkeys(groups[number].label for number in rows.groups):
        # A constraint with sums over rows, or of a struct in several places, has several groups.
        numbers = [number for number in rows.groups if groups[number].label == label]
        own = np.concatenate([np.flatnonzero(rows.group_of == number) for number in numbers])
        group = groups[numbers[0]]
        found = [
            (groups[number].table, int(row), problem.instance_place(number, instance))
            for number in numbers
            for instance, row in enumerate(problem.structure.active[number])
        ]
        order = sorted(range(len(found)), key=lambda k: found[k][:2])
        shape = (-1, group.residuals)
        parts.append(
            Requirement(
                label,
                group.require_text,
                tuple(found[k][2] for k in order),
                values[own].reshape(shape)[order],
                multipliers[own].reshape(shape)[order],
                active[own].reshape(shape)[order],
                group.units,
                group.require == "equal",
            )
        )
    return Required(
        tuple(parts),
        float(violations[at]) if at >= 0 else 0.0,
        limits.name(at) if at >= 0 else "",
        conflict,
    )
