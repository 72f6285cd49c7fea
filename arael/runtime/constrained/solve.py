"""One solve with exact rows, from its stored start to the accepted end."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from arael.config import LmConfig
from arael.diagnostics.records import Diagnostic
from arael.runtime.constrained.compiled import Exact
from arael.runtime.constrained.conflict import conflict_of
from arael.runtime.constrained.required import Required
from arael.runtime.constrained.rows import Rows, rows_of
from arael.runtime.failures import SolveError, listed
from arael.runtime.levenberg.diagnosis import check_linearisation
from arael.runtime.levenberg.trace import Watcher
from arael.runtime.linear.auto import make_solver
from arael.runtime.linear.compiled import LinearSolver
from arael.runtime.parallel.compiled import threads_for
from arael.runtime.problem import Problem
from arael.runtime.solve import Outcome

# An inequality acts where it is this many tolerances or less from its limit.
ACTS = 1e3


class ExactWatcher(Watcher):
    """Checks the start of a solve with exact rows."""

    def started(self, minimiser: Exact) -> None:
        """Raise SolveError if a solve cannot start here: E1001-E1004, E1019."""
        problem = self._problem
        rows = rows_of(problem)
        values, entries = rows.evaluate()
        violations = rows.violations(values)
        alone = np.bincount(rows.row, minlength=rows.count) == 0
        false = np.flatnonzero(alone & (violations > minimiser.tolerance))
        if len(false):
            raise _never(rows, violations, false)
        cost, gradient = minimiser.start_cost, minimiser.gradient
        if not np.isfinite(values).all():
            cost = math.nan
        if not np.isfinite(entries).all():
            gradient[:] = math.nan
        diagonal = minimiser.diagonal
        if self._lenient:
            diagonal = np.where(diagonal == 0, 1, diagonal)
        check_linearisation(problem, cost, gradient, diagonal)


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
    problem.check_start()
    problem.state_dirty = True
    rows = rows_of(problem)
    if solver.single or solver.plan.get("solver") == "schur_pcg":
        # Rows are weighted by more than single precision, or approximate steps, resolve.
        solver = make_solver("auto", problem.structure.pattern, False)
    solver.use_threads(threads)
    watcher = ExactWatcher(problem, write, config.observer, config.min_diagonal > 0)
    residuals = None
    if problem.hooks is None and problem.layout.precision == "f64":
        residuals = rows.residuals
    loop = Exact(problem.evaluation, rows, solver, config, watcher, watcher.watches, residuals)

    def outcome(status: str, cost: float, required: Required | None) -> Outcome:
        total = time.perf_counter() - began + problem.seconds + analysis_seconds
        history = loop.history
        return Outcome(
            problem.x,
            loop.start_cost,
            cost,
            len(history),
            loop.accepted,
            status,
            loop.damping,
            solver.report(),
            {"prepare": problem.seconds, "analyse": analysis_seconds, "total": total},
            history,
            np.nan,
            np.nan,
            np.nan,
            required=required,
        )

    try:
        status = loop.run()
    except SolveError as error:
        # What failed is not evaluated again.
        error.best = outcome("aborted", loop.current_cost, None)
        raise
    rows.multipliers = loop.multipliers
    conflict: tuple[str, ...] = ()
    if status == "infeasible":
        conflict = conflict_of(problem, rows, solver, config, loop)
        loop.multipliers[:] = 0.0
    if status in ("infeasible", "converged") and rows.count > rows.group_rows:
        rows.settle(loop.multipliers, loop.tolerance)
    return outcome(status, problem.cost(), _required_of(rows, loop, conflict))


def _required_of(rows: Rows, loop: Exact, conflict: tuple[str, ...]) -> Required:
    """What became of the rows, at the accepted state."""
    values, _ = rows.evaluate()
    violations = rows.violations(values) / np.maximum(loop.scale, 1e-300)
    at = int(violations.argmax()) if len(violations) else -1
    equal = rows.equal.astype(bool)
    # Of the cost, without the factor 1/2; of an equality what the cost falls by where the right
    # side grows.
    multipliers = np.where(equal, -2.0, 2.0) * loop.multipliers
    return Required(
        rows.parts,
        values,
        multipliers,
        equal | (np.abs(values) <= ACTS * loop.tolerance),
        float(violations[at]) if at >= 0 else 0.0,
        rows.name(at) if at >= 0 else "",
        conflict,
    )


def _never(rows: Rows, violations: Any, false: Any) -> SolveError:
    """E1019 for rows that nothing that moves can change, and that do not hold."""
    at = int(false[0])
    group = rows.problem.layout.groups[int(rows.group_of[at])]
    names = list(dict.fromkeys(rows.name(int(k)) for k in false))
    return SolveError(
        Diagnostic(
            "E1019",
            f"{listed(names)} {'does' if len(names) == 1 else 'do'} not hold, and no parameter "
            "that moves can change that",
            origin=group.where,
            notes=(f"`{group.require_text}` is off by {violations[at]:.6g}",),
            help=("correct the data, free a parameter that it reads, or give it a guard",),
        )
    )
