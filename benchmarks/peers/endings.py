"""What every system does for the suite `optimum`: solve from the start to its own end, in each way.

    python -m benchmarks.peers.NAME optimum SUITE PROBLEM RUNS LIMIT OUT

prints one JSON object: ``version``, ``setup`` (seconds of the processor to read the problem and to
build it in the system), and ``ways``, a list with for each way of solving

- ``name``, ``settings``; ``status``, the system's own words on its end, or what went wrong;
- ``attempts`` at a step in all; ``cost``, half or whole, as the system counts it, at the end;
- ``costs`` and ``counts``: cost and attempts at the start and after each iteration;
- ``runs``: of each timed run ``cpu`` and ``wall`` seconds, and ``times``, seconds of the
  processor at each of ``costs``.

The answer of the way numbered k goes to OUT.k.npz, in the terms of `benchmarks.problems`. Needs
nothing of arael: a system may live in another Python.
"""

from __future__ import annotations

import json
import os
import select
import signal
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

WORD = "optimum"
"""The first word of the command line that asks for this."""
BUDGET, LONG = 0.4, 0.5
"""Seconds of a way after which no further run is begun; of a first run that then counts."""
PATIENCE = float(os.environ.get("ARAEL_BENCH_PATIENCE", "60"))
"""Seconds by the clock after which a way is given up."""


@dataclass
class Path:
    """What a run has recorded: a cost an iteration, with attempts and seconds until then."""

    began: float = field(default_factory=time.process_time)
    costs: list[float] = field(default_factory=list)
    counts: list[int] = field(default_factory=list)
    times: list[float] = field(default_factory=list)

    def mark(self, cost: float, attempts: int) -> None:
        """Record the cost after so many attempts, now."""
        self.costs.append(float(cost))
        self.counts.append(int(attempts))
        self.times.append(time.process_time() - self.began)


class Solving(Protocol):
    """A problem set up in one system, to be solved in several ways."""

    def ways(self) -> Mapping[str, str]:
        """Names of the ways, with the settings of each in words."""

    def fresh(self) -> None:
        """Go back to the start; nothing that a solve computed is kept."""

    def solve(self, way: str, path: Path, limit: int) -> str:
        """Solve to the system's own end within `limit` iterations; return its words on it."""

    def answer(self) -> dict[str, np.ndarray]:
        """The state, in the terms of `benchmarks.problems`."""


def main(version: str, suites: Mapping[str, Callable[[str, int], Any]]) -> dict[str, Any]:
    """Solve one problem in all ways; return what is to be printed."""
    suite, problem, runs, limit, out = request()
    began = time.process_time()
    system = suites[suite](problem, 1)
    setup = time.process_time() - began
    ways = []
    for number, (name, settings) in enumerate(chosen(system.ways()).items()):
        found = _apart(system, name, runs, limit, f"{out}.{number}.npz")
        ways.append({"name": name, "settings": settings, **found})
    return {"version": version, "setup": setup, "ways": ways}


def request() -> tuple[str, str, int, int, str]:
    """Suite, problem, runs, limit and where answers go, of the command line."""
    suite, problem, runs, limit, out = sys.argv[2:7]
    return suite, problem, int(runs), int(limit), out


def chosen(ways: Mapping[str, str]) -> dict[str, str]:
    """All ways, or the first alone where `ARAEL_BENCH_FIRST` asks for that."""
    return dict(list(ways.items())[: 1 if os.environ.get("ARAEL_BENCH_FIRST") else None])


def failed(why: str) -> dict[str, Any]:
    """The record of a way without an end."""
    return {"status": why, "attempts": 0, "cost": None, "costs": [], "counts": [], "runs": []}


def _apart(system: Solving, name: str, runs: int, limit: int, out: str) -> dict[str, Any]:
    """Solve in a process of its own: some systems crash or do not come to an end in some ways."""
    reading, writing = os.pipe()
    process = os.fork()
    if process == 0:
        try:
            found = _way(system, name, runs, limit)
            if found["runs"]:
                np.savez(out, **system.answer())
            os.write(writing, json.dumps(found).encode())
        finally:
            os._exit(0)
    os.close(writing)
    said, began = b"", time.perf_counter()
    late = False
    while not late:
        left = PATIENCE - (time.perf_counter() - began)
        late = not select.select([reading], [], [], max(left, 0.0))[0]
        part = b"" if late else os.read(reading, 1 << 16)
        said += part
        if not part:
            break
    os.close(reading)
    os.kill(process, signal.SIGKILL)
    os.waitpid(process, 0)
    if late:
        return failed(f"not done in {PATIENCE:.0f} s")
    return json.loads(said) if said else failed("crashed")


def _way(system: Solving, name: str, runs: int, limit: int) -> dict[str, Any]:
    timed: list[dict[str, Any]] = []
    spent = 0.0
    path, status = Path(), "interrupted"
    for k in range(runs + 1):
        if spent > BUDGET and timed:
            break
        system.fresh()
        wall, path = time.perf_counter(), Path()
        try:
            status = system.solve(name, path, limit)
        except RuntimeError as error:
            return _record(str(error).strip().splitlines()[0], path, [])
        cpu, wall = time.process_time() - path.began, time.perf_counter() - wall
        spent += cpu
        # What is loaded and allocated once does not count, but a long run is not made twice.
        if k > 0 or cpu > LONG:
            timed.append({"cpu": cpu, "wall": wall, "times": path.times})
    return _record(status, path, timed)


def _record(status: str, path: Path, timed: list[dict[str, Any]]) -> dict[str, Any]:
    return {
        "status": status,
        "attempts": path.counts[-1] if path.counts else 0,
        "cost": path.costs[-1] if path.costs and timed else None,
        "costs": path.costs,
        "counts": path.counts,
        "runs": timed,
    }
