"""One solve of one problem, from its stored start to the accepted end."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from arael.config import LmConfig
from arael.runtime.assembly.components import Partition, partition_of
from arael.runtime.failures import SolveError
from arael.runtime.levenberg.compiled import Minimiser
from arael.runtime.levenberg.outcomes import Components, components_of
from arael.runtime.levenberg.trace import Watcher
from arael.runtime.linear.compiled import LinearSolver
from arael.runtime.parallel.compiled import threads_for
from arael.runtime.problem import Problem
from arael.runtime.store.access import Array

if TYPE_CHECKING:
    from arael.runtime.constrained.required import Required
    from arael.runtime.levenberg.compiled import InnerSteps


@dataclass  # not frozen: its constructor would take three times as long
class Outcome:
    """Result of a solve; the problem's accepted state is the best one found.

    Attributes
    ----------
    history : attempts, structured array of `arael.runtime.levenberg.compiled.RECORD`
    timing : seconds per phase
    plan : what the linear solver chose and why
    components : what became of each connected component; None if all was solved as one
    information : (n,) diagonal of J'J at the last linearisation, and (n,) the largest one in the
        solve, where a constraint has a loss
    undamped : whether the linear solver has a factor, with the damping of the last attempt
    required : what became of the rows that hold exactly; None if there are none
    """

    x: Array
    start_cost: float
    end_cost: float
    iterations: int
    accepted_iterations: int
    status: str
    final_lambda: float
    plan: dict[str, Any]
    timing: dict[str, float]
    history: Array
    predicted_decrease: float
    gradient_norm: float
    noise_floor: float
    components: Components | None = None
    information: tuple[Array, Array] | None = None
    undamped: bool = False
    required: Required | None = None


def minimise(
    problem: Problem,
    config: LmConfig,
    solver: LinearSolver,
    write: Callable[[str], object] | None = None,
    analysis_seconds: float = 0.0,
) -> Outcome:
    """Run the loop; the store is not touched.

    Parameters
    ----------
    write : takes each line of the trace; default stderr if the configuration is verbose

    Raises
    ------
    SolveError
        E1001-E1007, with the outcome so far in ``best``. What observers and drivers raise passes.
    """
    config = _suited(config, solver)
    if write is None and config.verbose:
        write = to_stderr
    began = time.perf_counter()
    threads = threads_for(config.num_threads)
    problem.evaluation.threads = threads
    solver.use_threads(threads)
    problem.check_start()
    problem.state_dirty = True
    watcher = Watcher(problem, write, config.observer, config.min_diagonal > 0)
    partition = partition_for(problem, config, solver)
    if partition is not None and config.rel_precision is None:
        config = config.for_components(int(np.bincount(partition.of_scalar).max()))
    minimiser = Minimiser(
        problem.evaluation,
        solver,
        problem.box,
        config,
        watcher,
        watcher.watches,
        partition,
        separable_for(problem, config, solver, partition),
    )

    def outcome(status: str) -> Outcome:
        timing = {
            "prepare": problem.seconds,
            "analyse": analysis_seconds,
            **minimiser.timing,
        }
        timing["total"] = time.perf_counter() - began + problem.seconds + analysis_seconds
        return Outcome(
            problem.x,
            minimiser.start_cost,
            # Guards are asked once more: the last step may have switched instances.
            problem.cost() if problem.evaluation.guarded else minimiser.current_cost,
            minimiser.attempts,
            minimiser.accepted,
            status,
            minimiser.damping,
            solver.report() | _measured(solver, minimiser),
            timing,
            minimiser.history,
            minimiser.predicted_decrease,
            minimiser.gradient_norm,
            minimiser.noise_floor,
            None if partition is None else components_of(problem, partition, minimiser.components),
            _information(problem, minimiser, partition is None),
            bool(minimiser.factorisations) and bool(minimiser.history["factored"][-1:].all()),
        )

    try:
        status = minimiser.run()
    except SolveError as error:
        error.best = outcome("aborted")
        raise
    return outcome(status)


def _information(
    problem: Problem, minimiser: Minimiser, as_one: bool
) -> tuple[Array, Array] | None:
    if not problem.layout.robust or type(problem) is not Problem:
        return None
    vectors = minimiser.vectors
    # The values of components that ended earlier are empty.
    values = vectors.value_array if as_one else problem.evaluation.linearised()[2]
    now = np.array(values[problem.diagonal_at], dtype=np.float64)
    return now, np.maximum(vectors.scale_array, vectors.diagonal_array).astype(np.float64)


def _suited(config: LmConfig, solver: LinearSolver) -> LmConfig:
    """The configuration, with damped steps in place of the dogleg where steps are approximate.

    Conjugate gradients need the damping: without it they are slow along what nothing holds, and
    stop short of the Gauss-Newton step that the dogleg relies on.
    """
    approximate = solver.plan.get("solver") == "schur_pcg"
    if approximate and config.strategy == "auto" and config.chosen_strategy() == "dogleg":
        return replace(config, strategy="damped", damping="ladder")
    return config


def separable_for(
    problem: Problem, config: LmConfig, solver: LinearSolver, partition: Partition | None
) -> Callable[[], InnerSteps | None] | None:
    """What makes inner iterations, where the automatic strategy may take them."""
    automatic = config.strategy == "auto" and config.chosen_strategy() == "dogleg"
    usual = config.ending == "promise" and config.min_diagonal == 0
    if partition is not None or not (automatic and usual and solver.plan.get("solver") == "schur"):
        return None
    # Imported here for start-up time: most solves take no inner iterations.
    from arael.runtime.levenberg.separable import inner_steps

    return partial(inner_steps, problem, solver, config.floor(bool(solver.single)))


def partition_for(problem: Problem, config: LmConfig, solver: LinearSolver) -> Partition | None:
    """The components that are solved separately; None if the problem is solved as one.

    A custom driver moves one lambda, the reference's end looks at one cost, approximate steps of
    one component depend on the others, and look-ups of parameters may lead into other components.
    """
    if callable(config.damping) or config.ending != "promise":
        return None
    if any(group.moves_rows for group in problem.layout.groups):
        return None
    if solver.plan.get("solver") == "schur_pcg":
        return None
    return partition_of(problem.structure, problem.layout.groups)


def _measured(solver: LinearSolver, minimiser: Minimiser) -> dict[str, float]:
    """What a factorisation took, to stand beside what was predicted; nothing if there was none.

    The first, which touches all memory for the first time, counts only where it is the only one.
    What iterates was predicted with its iterations, so it is measured with them.
    """
    timing, count = minimiser.timing, minimiser.factorisations
    if not count:
        return {}
    seconds = minimiser.factor_seconds / (count - 1) if count > 1 else timing["first_factor"]
    if solver.plan.get("solver") == "schur_pcg":
        seconds += timing["solve"] / count
    return {"measured_ms": 1e3 * seconds}


def to_stderr(line: str) -> None:
    """Print a line of the trace on stderr."""
    print(line, file=sys.stderr, flush=True)
