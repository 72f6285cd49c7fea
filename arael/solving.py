"""Solving a model: its passes in order, each a separate nonlinear least-squares solve."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Iterable, Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from functools import lru_cache
from typing import Any, Protocol

import numpy as np

from arael.config import LmConfig, Observer
from arael.diagnostics.arguments import wrong_argument
from arael.diagnostics.records import AraelError, Diagnostic
from arael.display.progress import shown
from arael.log import LEVELS, log, logger
from arael.notes import (
    Checks,
    extent_of,
    frozen_note,
    looks_for_symmetries,
    structural_notes,
)
from arael.result import Plan, Result, joined
from arael.runtime.evaluation.states import put_values
from arael.runtime.failures import FunctionError, SolveError
from arael.runtime.layout import Layout, LayoutPass
from arael.runtime.linear.compiled import LinearSolver, is_blas_loaded
from arael.runtime.linear.options import typed_options
from arael.runtime.problem import Problem
from arael.runtime.solve import Outcome, minimise, to_stderr
from arael.schedule import (
    Pass,
    check_paths,
    chosen_passes,
    frozen_after,
    frozen_paths,
    held_by,
)
from arael.session import Session, session_of
from arael.statuses import ENDING

Trace = Callable[[str], object]
StepObserver = Callable[[Any, Any], bool | None]
"""A function of a model after an accepted step, and of the record of the step."""

_UNLIMITED: AbstractContextManager[None] = nullcontext()


class Solvable(Protocol):
    """What solving needs of a model instance."""

    _compiled: Any
    _store: Any


def solve(
    model: Solvable,
    config: LmConfig | None = None,
    solver: str = "auto",
    passes: str | Pass | LayoutPass | Iterable[str | Pass | LayoutPass] | None = None,
    *,
    freeze: str | Iterable[str] = (),
    observer: Observer | None = None,
    on_step: StepObserver | None = None,
    trace: Trace | None = None,
    solver_options: Mapping[str, Any] | None = None,
    progress: bool | None = None,
    **settings: Any,
) -> Result:
    """Minimise the sum of squared residuals; the solved parameters are written into the model.

    Root data that a pass sets keeps its value. After each pass its solution is in the model, and
    ``x.value`` in constraints of the next pass means that solution. A solve that ends early
    (Ctrl-C, time limit, observer) keeps the best state found and skips the remaining passes.

    Parameters
    ----------
    config : settings of the loop; settings of a pass override it, and `settings` override both
    solver : linear solver: ``auto``, ``dense``, ``band``, ``sparse``, ``schur``, ``schur_pcg``,
        ``cholmod``, ...
    passes : names of the model's passes to run, or `arael.Pass`; None: all of the model, or one
        plain solve if it declares none; an empty list: one plain solve
    freeze : paths of parameters to freeze, or of what contains them (``"poses.ea"``, ``"poses"``),
        or the same by the name of a struct, wherever it is used (``"Pose.ea"``, ``"Pose"``)
    observer : called with the record of each attempt; returning False ends the solve
    on_step : called with a model and a record after each accepted step; returning False ends the
        solve. The model is a copy that has the values after the step
    trace : called with each line of the trace; default stderr if ``verbose``
    solver_options : options of the linear solver by name
    progress : whether to show the progress of a solve of more than a second, in the cell of a
        notebook or on a terminal; None: in notebooks and at an interactive prompt
    **settings : single settings of `LmConfig` by name

    Returns
    -------
    Result

    Raises
    ------
    SolveError
        E1001-E1007: the problem cannot be solved, with the result so far in ``best``. The model
        keeps the solution of the passes before.
    AraelError
        E1010 a bad setting, E1011 an unknown pass, E1012 an unknown path to freeze, E0840-E0842 an
        unknown solver or a bad option of it, E0702 data that the root lacks, E0701-E0706 data of a
        pass that does not fit, E1040 another thread is solving this instance.
    """
    options = typed_options(solver, solver_options)
    model._store.check_complete()
    layout = layout_of(model)
    if observer is not None:
        settings["observer"] = observer
    if trace is not None and not callable(trace):
        raise wrong_argument("solve", "trace", "a function of a line", trace, "`trace=print`")
    if on_step is not None and not callable(on_step):
        raise wrong_argument("solve", "on_step", "a function of a model and a record", on_step)
    if progress is not None and not isinstance(progress, bool):
        raise wrong_argument("solve", "progress", "True, False or None", progress)
    if config is not None and not isinstance(config, LmConfig):
        raise AraelError(
            Diagnostic(
                "E1010",
                f"`config` is an `arael.LmConfig`, found {type(config).__name__}",
                origin="solve",
                help=("write single settings by name, such as `solve(max_iters=50)`",),
            )
        )
    base = config.with_() if config is not None else LmConfig.of()
    schedule = chosen_passes(layout, passes)
    configs = [base.with_(**{**one.config, **settings}) for one in schedule]
    frozen = frozen_by(layout, schedule, freeze)
    began = time.perf_counter()
    results: list[Result] = []
    use = model._store.use
    with (
        use.solving(),
        session_of(model).held() as session,
        shown(False if trace is not None else progress) as watch,
    ):
        if session is session_of(model):  # not a solve within a solve
            change_over(model, session)
        for one, pass_config in zip(schedule, configs, strict=True):
            set_root(model, one)
            write = _writer(trace, pass_config.verbose)
            if len(schedule) > 1 and write is not None:
                write(f"pass {one.name}")
            now = frozen_after(layout, frozen, one) if one.freeze or one.free else frozen
            if pass_config.time_limit is not None:
                left = max(0.0, pass_config.time_limit - (time.perf_counter() - began))
                pass_config = replace(pass_config, time_limit=left)
            if watch is not None and not pass_config.verbose:
                pass_config = replace(pass_config, observer=watch.with_(pass_config.observer))
            problem = current_problem(model, session, now)
            problem.check_start()
            if on_step is not None:
                observed = _after_steps(on_step, model, problem, pass_config.observer)
                pass_config = replace(pass_config, observer=observed)
            session.counts.solves += 1
            linear, seconds = session.linear(problem, solver, options)
            try:
                with blas_threads(pass_config.num_threads):
                    if any(group.moves_rows for group in problem.layout.groups):
                        # imported here: start-up time; few models look up parameters
                        from arael.runtime.following import follow

                        again = _again(model, session, now, solver, options)
                        problem, linear, outcome = follow(
                            problem, pass_config, linear, write, seconds, _minimise, again
                        )
                    else:
                        outcome = _minimise(problem, pass_config, linear, write, seconds)
            except SolveError as error:
                if error.best is not None:
                    if isinstance(error, FunctionError):
                        problem.write_back()
                    done = [*results, result_of(error.best, one.name)]
                    error.best = joined(done, layout.name)
                raise
            problem.write_back()
            results.append(result_of(outcome, one.name))
            if now:
                results[-1].__dict__["frozen"] = frozen_paths(layout, now)
            _log_result(layout.name, results[-1])
            for note in () if problem.hooks is None else problem.hooks.notes:
                log("solve", "info", f"{layout.name}: {note}")
            if outcome.status in ENDING:
                break
        if outcome.status != "aborted":  # a function that was interrupted is not called again
            take_notes(session, problem, linear, outcome, results)
    found = joined(results, layout.name)
    found.__dict__["model"] = model
    return found


def _after_steps(
    on_step: StepObserver, model: Any, problem: Problem, observer: Observer | None
) -> Observer:
    """An observer that calls `on_step` with a copy of the model after each accepted step.

    The model itself keeps its values: constraints may read them by ``x.value``.
    """
    stepped = model.copy()
    store = posed(stepped)[1]

    def observed(record: Any) -> bool:
        answers = [] if observer is None else [observer(record)]
        if record["accepted"]:
            put_values(store, problem.structure.system, problem.x)
            answers.append(on_step(stepped, record))
        return all(answer is None or bool(answer) for answer in answers)

    return observed


def _minimise(
    problem: Problem,
    config: LmConfig,
    solver: LinearSolver,
    write: Trace | None,
    seconds: float,
) -> Outcome:
    if not problem.layout.required:
        return minimise(problem, config, solver, write, seconds)
    # imported here: start-up time; most models have no rows that hold exactly
    from arael.runtime.constrained.solve import minimise_exactly

    return minimise_exactly(problem, config, solver, write, seconds)


def _again(
    model: Solvable,
    session: Session,
    frozen: frozenset[str],
    solver: str,
    options: Mapping[str, Any],
) -> Callable[[Problem], tuple[Problem, LinearSolver, float]]:
    """What makes the problem at an accepted state, with its linear solver and seconds of it."""

    def again(before: Problem) -> tuple[Problem, LinearSolver, float]:
        before.write_back()
        problem = current_problem(model, session, frozen)
        return problem, *session.linear(problem, solver, options)

    return again


def frozen_by(
    layout: Layout, schedule: Iterable[LayoutPass], freeze: str | Iterable[str]
) -> frozenset[str]:
    """Paths that `freeze` names, and their parts; those of the passes are checked too.

    Raises
    ------
    AraelError
        E1010 what is no path; E1012 a path that names no parameter.
    """
    if (
        isinstance(freeze, tuple)
        and not freeze
        and not any(one.freeze or one.free for one in schedule)
    ):
        return frozenset()
    given = [freeze] if isinstance(freeze, str) or not isinstance(freeze, Iterable) else [*freeze]
    if not all(isinstance(path, str) for path in given):
        raise wrong_argument("solve", "freeze", "paths of parameters", freeze)
    paths = [*given, *(p for one in schedule for p in (*one.freeze, *one.free))]
    if not paths:
        return frozenset()
    check_paths(layout, paths)
    return held_by(layout, given)


def current_problem(model: Solvable, session: Session, frozen: frozenset[str]) -> Problem:
    """The problem of the session at the current values, a new one if the structure changed."""
    with model._store.use.lock:
        found = session.refreshed(posed(model)[1], frozen)
        return found or session.keep(problem_of(model, frozen, keep_idle=True))


def change_over(model: Solvable, session: Session) -> None:
    """Take kernels that were compiled meanwhile in place of the expression machine."""
    known = model._compiled
    if getattr(known, "meanwhile", None) is None:
        return
    with model._store.use.lock:
        current = known.current(level=5)
        if current is known:
            return
        object.__setattr__(model, "_compiled", current)
        model._store.kernels = current.kernels
        session.release()  # its data lies as the expression machine reads it


def problem_of(model: Solvable, frozen: Iterable[str] = (), *, keep_idle: bool = False) -> Problem:
    """The problem of a model at its current values.

    What has not changed since the last solve is reused. With `keep_idle`, rows of parameters that
    were fixed since then may remain in the system as held rows.
    """
    compiled = model._compiled
    bindings = getattr(compiled, "bindings", None) or {}
    with model._store.use.lock:
        layout, store, programs = posed(model)
        return Problem(
            layout,
            store,
            compiled.kernels,
            frozen=frozenset(frozen),
            programs=programs,
            bindings={**bindings, **getattr(store, "bindings", {})},
            earlier=session_of(model).earlier,
            keep_idle=keep_idle,
        )


def layout_of(model: Solvable) -> Layout:
    """Layout of a model, the residuals added at run time included."""
    return posed(model)[0]


def posed(model: Solvable) -> tuple[Layout, Any, Any]:
    """Layout, data and programs of a model, the residuals added at run time included."""
    residuals = getattr(model, "_residuals", None)
    if residuals is None:
        return model._compiled.layout, model._store, None
    posed = residuals.posed()
    return posed.layout, posed, posed.programs


def cost(model: Solvable) -> float:
    """Sum of squared residuals at the present values."""
    model._store.check_complete()
    return problem_of(model).cost()


def blas_threads(count: int) -> AbstractContextManager[Any]:
    """Limit the threads of BLAS, if a solver has loaded it; 0: as many as it likes."""
    # Not imported for this alone: most problems are solved without BLAS, and it loads slowly.
    loaded = is_blas_loaded(), "sksparse.cholmod" in sys.modules
    if count == 0 or not any(loaded):
        return _UNLIMITED
    limited: AbstractContextManager[Any] = _threadpools(*loaded).limit(
        limits=count, user_api="blas"
    )
    return limited


@lru_cache(maxsize=3)
def _threadpools(scipy: bool, suitesparse: bool) -> Any:
    """The thread pools of this process, listed again after a library with another is loaded."""
    # imported here: start-up time
    from threadpoolctl import ThreadpoolController  # type: ignore[import-untyped]

    return ThreadpoolController()


def set_root(model: Solvable, one: LayoutPass) -> None:
    """Set the data of the root that a pass sets."""
    root = model._store.tables[""]
    for setting in one.settings:
        column = root.column(setting.column)
        column[0] = np.reshape(np.asarray(setting.value), column.shape[1:])


def _writer(trace: Trace | None, verbose: bool) -> Trace | None:
    """Who takes the lines of the trace: `trace`, stderr if `verbose`, the log if it is heard."""
    first = trace or (to_stderr if verbose else None)
    heard = logger("solve", LEVELS["debug"])
    if heard is None:
        return first
    if first is None:
        return lambda line: heard.debug("%s", line)

    def both(line: str) -> None:
        first(line)
        heard.debug("%s", line)

    return both


def _log_result(model: str, result: Result) -> None:
    level = "info" if result.converged else "warning"
    if logger("solve", LEVELS[level]) is not None:
        name = model if result.name == "solve" else f"{model}, pass {result.name}"
        log("solve", level, f"{name}: {str(result).splitlines()[0]}, solver {result.plan}")


def take_notes(
    session: Session,
    problem: Problem,
    linear: LinearSolver,
    outcome: Outcome,
    results: list[Result],
) -> None:
    """Give the last result what its notes are made from."""
    structural = session.structural
    if structural is None or structural[0] is not problem.structure:
        whole = outcome.components is None and outcome.undamped
        damping = float(outcome.history["damping"][-1]) if whole else math.nan
        extent = extent_of(problem)
        # What held the map holds it when only rows were added, or more is fixed.
        session.determined &= (
            structural is not None
            and structural[1] == ()
            and len(extent) == len(structural[2])  # residuals may be added at run time
            and all(now >= then for now, then in zip(extent, structural[2], strict=True))
        )
        found = structural_notes(problem, linear, damping, session.determined)
        session.structural = structural = (problem.structure, found, extent)
        session.determined |= found == () and looks_for_symmetries(problem)
    last = results[-1].__dict__
    notes = structural[1]
    if len(results) > 1:
        notes = (*notes, *frozen_note(last["frozen"], last["name"]))
    last["checks"] = Checks(notes, problem.structure, outcome.x, outcome.information)
    if logger("solve", LEVELS["warning"]) is not None:
        for note in results[-1].notes:
            log("solve", "warning", f"{problem.layout.name}: {note.message}")


def result_of(outcome: Outcome, name: str) -> Result:
    """What a pass came to, as users see it."""
    made = object.__new__(Result)  # the constructor of a frozen class takes twice as long
    made.__dict__.update(
        outcome.__dict__, plan=Plan(outcome.plan), name=name, passes=(), frozen=(), checks=None
    )
    del made.__dict__["information"], made.__dict__["undamped"]
    return made
