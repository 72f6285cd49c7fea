"""What every system does in its process: solve from the start, short and long, and show its answer.

    python -m benchmarks.peers.NAME SUITE PROBLEM SHORT LONG RUNS OUT.npz

prints one JSON object: ``slopes`` (seconds per iteration, from runs of SHORT and LONG iterations,
so that set-up is told apart), ``memory`` (peak resident MB), ``version``, ``settings``. The answer
goes to OUT.npz in the terms of `benchmarks.problems`. Needs nothing of arael: a system may live in
another Python.
"""

from __future__ import annotations

import json
import resource
import sys
import time
from collections.abc import Callable, Mapping
from typing import Protocol

import numpy as np

CONVERGED = 100
"""Iterations of the run whose answer is compared."""


class Peer(Protocol):
    """A problem set up in one system."""

    settings: str

    def start(self) -> None:
        """Go back to the start, ready to iterate."""

    def iterate(self, count: int) -> int:
        """Iterate at most `count` times; return how many it were."""

    def answer(self) -> dict[str, np.ndarray]:
        """The state, in the terms of `benchmarks.problems`."""


def main(version: str, suites: Mapping[str, Callable[[str], Peer]]) -> None:
    """Run one suite of this system."""
    suite, problem, short, long, runs, out = sys.argv[1:7]
    if suite not in suites:
        print(json.dumps({"absent": f"no {suite} here"}))
        return
    peer = suites[suite](problem)
    _timed(peer, int(short))  # what is loaded and allocated once does not count
    slopes = []
    for _ in range(int(runs)):
        (a, n), (b, m) = _timed(peer, int(short)), _timed(peer, int(long))
        if m > n:
            slopes.append((b - a) / (m - n))
    peer.start()
    iterations = peer.iterate(CONVERGED)
    np.savez(out, **peer.answer())
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(
        json.dumps(
            {
                "slopes": slopes,
                "iterations": iterations,
                "memory": memory,
                "version": version,
                "settings": peer.settings,
            }
        )
    )


def _timed(peer: Peer, count: int) -> tuple[float, int]:
    peer.start()
    began = time.perf_counter()
    done = peer.iterate(count)
    return time.perf_counter() - began, done
