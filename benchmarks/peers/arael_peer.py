"""arael itself, in the same harness."""

from __future__ import annotations

import os
from typing import Any

import numpy as np

import arael
from benchmarks import problems
from benchmarks.peers.runner import main

SOLVER: Any = os.environ.get("ARAEL_BENCH_SOLVER", "auto")
PRECISION: Any = os.environ.get("ARAEL_BENCH_PRECISION", "f64")
UNSTOPPED = {"min_iters": 10_000, "patience": 10_000, "abs_precision": 0.0, "rel_precision": 0.0}


class Arael:
    """A model with data."""

    def __init__(self, instance: Any, kind: Any, threads: int) -> None:
        self.instance, self.kind, self.threads = instance, kind, threads
        self.first = kind.state(instance)
        self.settings = f"{SOLVER}, {PRECISION}"
        self.facts: dict[str, float] = {}

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

    def answer(self) -> dict[str, np.ndarray]:
        return self.kind.state(self.instance)


def _make(suite: str) -> Any:
    kind = problems.KINDS[suite]
    return lambda path, threads: Arael(kind.load(path, precision=PRECISION), kind, threads)


if __name__ == "__main__":
    main(f"arael {arael.__version__}", {suite: _make(suite) for suite in problems.KINDS})
