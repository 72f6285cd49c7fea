"""arael itself, in the same harness."""

from __future__ import annotations

import os
from typing import Any

import numpy as np

import arael
from benchmarks import problems
from benchmarks.peers.runner import main

SOLVER = os.environ.get("ARAEL_BENCH_SOLVER", "auto")
PRECISION: Any = os.environ.get("ARAEL_BENCH_PRECISION") or None
THREADS = int(os.environ.get("ARAEL_BENCH_THREADS", "1"))


class Arael:
    """A model with data; iterations are timed inside, from the first linearisation on."""

    def __init__(self, instance: Any, kind: Any) -> None:
        self.instance, self.kind = instance, kind
        self.first = kind.state(instance)
        self.settings = SOLVER

    def start(self) -> None:
        self.kind.put(self.instance, self.first)

    def iterate(self, count: int) -> int:
        result = self.instance.solve(
            solver=SOLVER,
            max_iters=count,
            num_threads=THREADS,
            **({} if count > 50 else UNSTOPPED),
        )
        self.settings = f"solver {result.plan['solver']}"
        return int(result.iterations)

    def answer(self) -> dict[str, np.ndarray]:
        return self.kind.state(self.instance)


UNSTOPPED = {"min_iters": 50, "patience": 50, "abs_precision": 0.0, "rel_precision": 0.0}


def _make(suite: str) -> Any:
    kind = problems.KINDS[suite]
    return lambda path: Arael(kind.load(path, precision=PRECISION), kind)


if __name__ == "__main__":
    main(f"arael {arael.__version__}", {suite: _make(suite) for suite in problems.KINDS})
