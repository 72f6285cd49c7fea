"""Solves whose look-ups choose rows by parameters: the structure follows the accepted state.

Costs are exact at every trial state. Derivatives are those of the rows in the structure, so that a
solve is interrupted where an accepted step leads an argument out of its interval, and goes on with
the rows that are near it then.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from arael.config import LmConfig
from arael.runtime.linear.compiled import LinearSolver
from arael.runtime.nearness import has_moved
from arael.runtime.problem import Problem
from arael.runtime.solve import Outcome

Trace = Callable[[str], object]
Minimise = Callable[[Problem, LmConfig, LinearSolver, "Trace | None", float], Outcome]
Again = Callable[[Problem], tuple[Problem, LinearSolver, float]]


def follow(
    problem: Problem,
    config: LmConfig,
    solver: LinearSolver,
    write: Trace | None,
    seconds: float,
    minimise: Minimise,
    again: Again,
) -> tuple[Problem, LinearSolver, Outcome]:
    """Minimise, with the structure made anew by `again` whenever an argument leaves its interval.

    Parameters
    ----------
    seconds : spent on the analysis of `solver`
    again : from a problem at an accepted state the problem with the rows near it, its linear solver
        and the seconds spent on the analysis

    Returns
    -------
    The last problem, its linear solver, and the outcome of all parts together.
    """
    began = time.perf_counter()
    parts: list[Outcome] = []
    while True:
        watch = _Watch(problem, config.observer)
        part = minimise(problem, replace(config, observer=watch), solver, write, seconds)
        parts.append(part)
        left = config.max_iters - part.iterations
        if not watch.moved or watch.stopped or part.status in ("aborted", "time_limit"):
            return problem, solver, _joined(parts)
        if left <= 0:
            part.status = "max_iterations"
            return problem, solver, _joined(parts)
        if config.time_limit is not None:
            limit = max(0.0, config.time_limit - (time.perf_counter() - began))
            config = replace(config, time_limit=limit)
            began = time.perf_counter()
        config = replace(config, max_iters=left)
        problem, solver, seconds = again(problem)


class _Watch:
    """Ends a part of a solve once an argument has left its interval.

    Attributes
    ----------
    moved : whether one has
    stopped : whether the observer of the caller ended the solve
    """

    def __init__(self, problem: Problem, observer: Callable[[Any], bool | None] | None) -> None:
        self.problem, self.observer = problem, observer
        self.moved = self.stopped = False

    def __call__(self, record: Any) -> bool:
        if self.observer is not None:
            answer = self.observer(record)
            self.stopped = not (answer is None or bool(answer))
        if record["accepted"]:
            self.moved = has_moved(self.problem)
        return not (self.moved or self.stopped)


def _joined(parts: list[Outcome]) -> Outcome:
    last = parts[-1]
    if len(parts) == 1:
        return last
    timing = {
        name: sum(part.timing.get(name, 0.0) for part in parts)
        for name in dict.fromkeys(name for part in parts for name in part.timing)
    }
    return replace(
        last,
        start_cost=parts[0].start_cost,
        iterations=sum(part.iterations for part in parts),
        accepted_iterations=sum(part.accepted_iterations for part in parts),
        timing=timing,
        history=np.concatenate([part.history for part in parts]),
    )
