"""What every system does in its process: solve from the start, short and long, and show its answer.

    python -m benchmarks.peers.NAME SUITE PROBLEM SHORT LONG RUNS THREADS LIMIT OUT.npz

prints one JSON object: ``slopes`` (seconds per iteration, from runs of SHORT and LONG iterations,
so that set-up is told apart), ``memory`` (peak resident MB), ``version``, ``settings``, ``facts``
(what else a system knows of its size), ``residuals`` (what it minimises where that is not the
model); or ``absent``, the reason why it has no such problem. The
answer after at most LIMIT iterations goes to OUT.npz in the terms of `benchmarks.problems`. Needs
nothing of arael: a system may live in another Python.
"""

from __future__ import annotations

import json
import resource
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np

from benchmarks.peers import endings

BUDGET, LEAST = 6.0, 3
"""Seconds after which no further slope is begun, if there are so many."""
BRIEF, MOST = 1.0, 51
"""Seconds up to which further slopes are taken than were asked for, but no more than so many."""


@dataclass(frozen=True)
class Request:
    """What is to be run.

    Attributes
    ----------
    suite, problem : which file, and what it holds
    short, long, runs : numbers of iterations between which a slope is taken, and how many slopes
    threads : how many the system may use
    limit : iterations of the run whose answer is compared
    out : where the answer goes
    """

    suite: str
    problem: str
    short: int
    long: int
    runs: int
    threads: int
    limit: int
    out: str


class Peer(Protocol):
    """A problem set up in one system."""

    settings: str

    def start(self) -> None:
        """Go back to the start, ready to iterate."""

    def iterate(self, count: int, to_end: bool) -> int:
        """Iterate at most `count` times, all of them unless `to_end`; return how many it were."""

    def answer(self) -> dict[str, np.ndarray]:
        """The state, in the terms of `benchmarks.problems`."""


class AbsentError(Exception):
    """A problem that a system does not have; the words say why."""


LEFT = "left to "
"""How a program begins its words about what another program of the same system does."""

WHEELS = {"pyceres": "pyceres==2.6 pycolmap==3.13.0", "pycolmap": "pyceres==2.6 pycolmap==3.13.0"}
"""What to install for a module, where it is not the module's own name."""


def missing(module: str) -> str:
    """Say that a wheel is missing, and what to do about it."""
    return (
        f"{module} is not installed: `pip install {WHEELS.get(module, module)}`, or name the "
        "interpreter that has it with --peer-python"
    )


def request() -> Request:
    """Read the command line."""
    suite, problem, *numbers, out = sys.argv[1:9]
    return Request(suite, problem, *(int(n) for n in numbers), out=out)


def show(found: Mapping[str, object]) -> None:
    """Print what was measured, as the last line."""
    print(json.dumps(found))


def main(version: str, suites: Mapping[str, Callable[[str, int], Peer]]) -> None:
    """Run one suite of this system; a suite is made from the problem's path and the threads."""
    if sys.argv[1] == endings.WORD:
        show(_endings(version, suites))
        return
    asked = request()
    if asked.suite not in suites:
        show({"absent": f"no {asked.suite} in {version}"})
        return
    try:
        peer = suites[asked.suite](asked.problem, asked.threads)
    except AbsentError as reason:
        show({"absent": str(reason)})
        return
    slopes = _slopes(peer, asked)
    memory = _peak_megabytes()
    peer.start()
    iterations = peer.iterate(asked.limit, True)
    np.savez(asked.out, **peer.answer())  # type: ignore[arg-type]
    show(
        {
            "slopes": slopes,
            "iterations": iterations,
            "memory": memory,
            "version": version,
            "settings": peer.settings,
            "facts": getattr(peer, "facts", {}),
            "residuals": getattr(peer, "residuals", ""),
        }
    )


def _endings(version: str, suites: Mapping[str, Callable[[str, int], Peer]]) -> dict[str, object]:
    if sys.argv[2] not in suites:
        return {"absent": f"no {sys.argv[2]} in {version}"}
    try:
        return endings.main(version, suites)
    except AbsentError as reason:
        return {"absent": str(reason)}


def _peak_megabytes() -> float:
    """Peak resident memory of this process."""
    status = Path("/proc/self/status")
    if status.exists():  # what getrusage says counts the parent's memory at the fork
        for line in status.read_text().splitlines():
            if line.startswith("VmHWM:"):
                return int(line.split()[1]) / 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def _slopes(peer: Peer, asked: Request) -> list[float]:
    _timed(peer, asked.short)  # what is loaded and allocated once does not count
    slopes: list[float] = []
    began = time.perf_counter()
    for done in range(MOST):
        spent = time.perf_counter() - began
        if spent > BRIEF and (done >= asked.runs or (done >= LEAST and spent > BUDGET)):
            break
        (a, n), (b, m) = _timed(peer, asked.short), _timed(peer, asked.long)
        if m > n:
            slopes.append((b - a) / (m - n))
    return slopes


def _timed(peer: Peer, count: int) -> tuple[float, int]:
    peer.start()
    began = time.perf_counter()
    done = peer.iterate(count, False)
    return time.perf_counter() - began, done
