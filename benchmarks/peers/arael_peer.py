"""arael itself, in the same harness."""

from __future__ import annotations

import os
import sys
import time
from typing import Any

import numpy as np

import arael
from arael.runtime.assembly.scatter_plan import scatter_plan
from arael.runtime.system import build_system
from arael.starts.choose import can_initialise
from benchmarks import problems
from benchmarks.peers.endings import WORD, Path
from benchmarks.peers.runner import main

SOLVER: Any = os.environ.get("ARAEL_BENCH_SOLVER", "auto")
PRECISION: Any = os.environ.get("ARAEL_BENCH_PRECISION", "f64")
SHORT, COPIES = 0.03, 2
"""Seconds of a solve up to which it matters what it finds in the caches, and solves before it."""
UNSTOPPED = {"min_iters": 10_000, "patience": 10_000, "abs_precision": 0.0, "rel_precision": 0.0}


class Arael:
    """A model with data."""

    def __init__(self, instance: Any, kind: Any, threads: int, path: str = "") -> None:
        self.instance, self.kind, self.threads, self.path = instance, kind, threads, path
        self.first = kind.state(instance)
        self.settings = f"{SOLVER}, {PRECISION}"
        self.facts: dict[str, float] = {}
        self.last, self.spent = ("", 0), np.inf  # what `solve` was asked for, and its seconds

    def start(self) -> None:
        self.kind.put(self.instance, self.first)

    def iterate(self, count: int, to_end: bool) -> int:
        stop: dict[str, Any] = {"rel_precision": 1e-9} if to_end else UNSTOPPED
        # The time of an iteration is that of a damped one, as the peers make them: each attempt of
        # theirs factorises, while a rejected step of the trust region does not.
        config = arael.LmConfig() if to_end else arael.LmConfig.reference()
        result = self.instance.solve(
            config,
            solver=SOLVER,
            passes=self.kind.last_pass,
            max_iters=count,
            num_threads=self.threads,
            **stop,
        )
        self.settings = f"solver {result.plan['solver']}, {PRECISION}"
        self._weigh(result.plan)
        return int(result.iterations)

    def _weigh(self, plan: Any) -> None:
        """Note the bytes of the model's data and those of the factor's nonzeros."""
        tables = self.instance._store.tables.values()
        data = sum(t.column(c.path).nbytes for t in tables for c in t.layout.columns)
        scalar = 4 if PRECISION == "f32" else 8
        self.facts = {"data": data, "factor": scalar * plan.get("nnz_l", 0)}

    def ways(self) -> dict[str, str]:
        found = {"default": "as `arael solve` does, --init auto"}
        if can_initialise(self.instance):
            found["file"] = "--init file"
        return found

    def fresh(self) -> None:
        """Read the file and build the problem, as peers do: set-up, apart from the clock.

        Peers put their start values back and solve the same objects again, with program and data in
        the processor's caches. Here all is new, and to read a file leaves nothing in the caches; so
        a short solve follows a few of copies.
        """
        copies = []
        for _ in range(COPIES if self.spent < SHORT else 0):
            self.instance = self.kind.load(self.path, precision=PRECISION)
            self.build()
            copies.append(self.instance)
        self.instance = self.kind.load(self.path, precision=PRECISION)
        self.build()
        while copies:  # each leaves its memory to the next
            self._solve(copies.pop(), *self.last)

    def build(self) -> None:
        """Build the problem in arael, as a peer adds its factors; no part of the linear solver."""
        self.instance.prepare(SOLVER, self.kind.last_pass, analyse=False)

    def solve(self, way: str, path: Path, limit: int) -> str:
        """Start values, block pattern, ordering, analysis, steps and end: what counts for peers.

        Peers number their unknowns, find the block pattern of the Hessian and where each term is
        added in their solve. `build` has done so; it is done again here, so that the clock holds
        it.

        When each attempt ended follows from the seconds that the solve records of it: a callback
        in Python takes as long as a step of the smallest problems, those of the peers are native.
        What comes before the first attempt and after the last is counted as before. Those seconds
        are of the clock; they count for no more than the processor took.
        """
        result, words = self._solve(self.instance, way, limit)
        history = result.history
        ends = np.cumsum([0.0, *history["seconds"]])
        spent = time.process_time() - path.began
        self.last, self.spent = (way, limit), spent
        ends *= min(1.0, spent / ends[-1]) if ends[-1] > 0 else 1.0
        costs = np.where(history["accepted"], history["trial_cost"], history["cost"])
        path.costs = [result.start_cost, *costs.tolist()]
        path.counts = list(range(len(path.costs)))
        path.times = (spent - ends[-1] + ends).tolist()
        if len(costs):  # the last attempt includes the step at the end
            path.costs[-1], path.times[-1] = result.end_cost, spent
        return f"{result.status}{words}, {result.plan['solver']}"

    def _solve(self, instance: Any, way: str, limit: int) -> tuple[Any, str]:
        order_again(instance)
        words = ""
        if way == "default" and can_initialise(instance):
            words = f", start {arael.initialise(instance).chosen}"
        result = instance.solve(
            passes=self.kind.last_pass, max_iters=limit, num_threads=self.threads
        )
        return result, words

    def answer(self) -> dict[str, np.ndarray]:
        return self.kind.state(self.instance)


def order_again(instance: Any) -> None:
    """Number the unknowns of a prepared model, find pattern and offsets again; forget them."""
    problem = instance.session.earlier
    before = problem.structure
    system = build_system(problem.store, [blocks.free for blocks in before.system.blocks])
    plan = scatter_plan(problem.layout, before.slot_rows, before.active, system)
    for execution in before.plan._shares:
        plan.shares_for(execution)


def _make(suite: str) -> Any:
    kind = problems.KINDS[suite]

    def made(path: str, threads: int) -> Arael:
        system = Arael(kind.load(path, precision=PRECISION), kind, threads, path)
        if sys.argv[1] == WORD:
            system.build()
        return system

    return made


if __name__ == "__main__":
    main(f"arael {arael.__version__}", {suite: _make(suite) for suite in problems.KINDS})
