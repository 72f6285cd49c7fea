"""``python -m benchmarks constrained``: rows that hold exactly, beside CasADi with Ipopt.

A first solve of arael makes an instance of the loaded model and solves it; that of CasADi makes the
solver from the expressions and calls it. A second one starts again from the same values. Models are
compiled before, CasADi's callbacks are not. Times are those of the processor.
"""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import arael
from benchmarks.constrained import path as around
from benchmarks.constrained.formulas import FORMULAS, Formulas
from benchmarks.constrained.geometry import GEOMETRY
from benchmarks.constrained.infeasible import variants
from benchmarks.constrained.metrology import METROLOGY
from benchmarks.measure import table
from benchmarks.systems import Plan

POSES, QUICK_POSES = 200, 30
PATH_COST = {200: 3.0916950589}
RUNS, QUICK_RUNS = 7, 1
QUIET = {"ipopt.print_level": 0, "ipopt.sb": "yes", "print_time": 0, "error_on_fail": False}


@dataclass(frozen=True)
class Case:
    """One problem: an instance of its model, how values are put back, and CasADi's arguments."""

    name: str
    cost: float
    tolerance: float
    loaded: Any
    build: Callable[[], Any]
    casadi: Callable[[Any], dict[str, Any]]


@dataclass(frozen=True)
class Run:
    """Solves of one program: status, cost, iterations, seconds of a first and of a second."""

    converged: bool
    cost: float
    iterations: int
    first: float
    second: float


def cases(quick: bool, interpret: bool | None = None) -> list[Case]:
    """All problems with a solution."""
    options: dict[str, Any] = {} if interpret is None else {"interpret": interpret}
    found = [_small(one, options) for one in (*FORMULAS, *GEOMETRY, *METROLOGY)]
    count = QUICK_POSES if quick else POSES
    loaded = arael.loads(around.TEXT, name="path", **options)
    found.append(
        Case(
            f"path_{count}",
            PATH_COST.get(count, math.nan),
            1e-7,
            loaded,
            lambda: around.build(loaded, count),
            lambda ca: around.casadi(ca, count),
        )
    )
    return found


def _small(one: Formulas, options: dict[str, Any]) -> Case:
    loaded = arael.loads(one.text(), name=one.name, **options)
    return Case(one.name, one.cost, one.tolerance, loaded, lambda: loaded(**one.data()), one.casadi)


def by_arael(case: Case, runs: int) -> Run:
    """Medians of first and second solves."""
    firsts, seconds = [], []
    for _ in range(runs):
        began = time.process_time()
        model = case.build()
        result = model.solve()
        firsts.append(time.process_time() - began)
        model.deserialize(case.build().serialize())
        began = time.process_time()
        result = model.solve()
        seconds.append(time.process_time() - began)
    return Run(
        result.converged,
        result.cost,
        result.iterations,
        statistics.median(firsts),
        statistics.median(seconds),
    )


def by_ipopt(case: Case, runs: int, ca: Any) -> Run:
    """The same by CasADi."""
    firsts, seconds = [], []
    for _ in range(runs):
        began = time.process_time()
        arguments = case.casadi(ca)
        solver = ca.nlpsol("solver", "ipopt", arguments["nlp"], QUIET)
        found = solver(**arguments["call"])
        firsts.append(time.process_time() - began)
        began = time.process_time()
        found = solver(**arguments["call"])
        seconds.append(time.process_time() - began)
    statistic = solver.stats()
    return Run(
        bool(statistic["success"]),
        float(found["f"]),
        int(statistic["iter_count"]),
        statistics.median(firsts),
        statistics.median(seconds),
    )


def is_right(case: Case, run: Run) -> bool:
    """Whether a cost is that of the known optimum."""
    off = abs(run.cost - case.cost)
    return run.converged and off <= case.tolerance * max(1.0, abs(case.cost))


def run(plan: Plan, picture: Path | None) -> list[str]:
    """The chapter."""
    try:
        import casadi as ca
    except ImportError:
        ca = None
    runs = QUICK_RUNS if plan.quick else RUNS
    rows, right, ratios = [], [0, 0], ([], [])  # type: ignore[var-annotated]
    every = cases(plan.quick)
    for case in every:
        own = by_arael(case, runs)
        right[0] += is_right(case, own)
        row = [case.name, _cost(case, own), str(own.iterations), *_times(own)]
        if ca is not None:
            other = by_ipopt(case, runs, ca)
            right[1] += is_right(case, other)
            ratios[0].append(other.first / own.first)
            ratios[1].append(other.second / own.second)
            row += [_cost(case, other), str(other.iterations), *_times(other)]
            row += [f"{other.first / own.first:.1f}", f"{other.second / own.second:.1f}"]
        rows.append(row)
    head = ["problem", "arael", "iterations", "first ms", "second ms"]
    if ca is not None:
        head += ["Ipopt", "iterations", "first ms", "second ms", "first x", "second x"]
    named = sum(_named(one, conflict) for one, conflict in variants())
    lines = [
        "## Rows that hold exactly",
        "",
        f"Right to 1e-7: arael {right[0]} of {len(every)}"
        + (f", CasADi with Ipopt {right[1]}" if ca is not None else "; CasADi is not installed")
        + f". Infeasible variants named by their minimal set: {named} of {len(variants())}.",
    ]
    if ca is not None:
        first, second = (statistics.geometric_mean(one) for one in ratios)
        lines.append(
            f"Ratio of times to arael's, geometric mean: first solve {first:.1f}, second "
            f"{second:.1f}."
        )
    return [*lines, "", *table(head, rows)]


def _named(one: Formulas, conflict: frozenset[str]) -> bool:
    model = arael.loads(one.text(), name=f"{one.name}_infeasible", interpret=True)(**one.data())
    result = model.solve()
    return result.status == "infeasible" and {
        name.removeprefix("Problem.") for name in result.conflict
    } == set(conflict)


def _cost(case: Case, run: Run) -> str:
    return f"{run.cost:.8g}" + ("" if is_right(case, run) else " (not right)")


def _times(run: Run) -> list[str]:
    return [f"{1e3 * run.first:.2f}", f"{1e3 * run.second:.2f}"]
