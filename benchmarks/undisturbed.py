"""Runs during which a virtual machine had its processors.

Where other machines run on the same processors, the host takes them away for 1 to 100 milliseconds
now and then, and a high percentile is then that of the host. The kernel counts the time that it did
not get (*steal*), so that such runs can be told from others.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, TypeVar

T = TypeVar("T")

MOST = 0.002
"""Share of the processors' time that may be taken in a run that counts."""
ATTEMPTS = 5

_STAT = Path("/proc/stat")
_STEAL = 8
"""Column of the first line, in ticks of `SC_CLK_TCK` per second: proc(5)."""


@dataclass(frozen=True)
class Run(Generic[T]):
    """What was measured, and the share of the processors' time that the host took meanwhile."""

    found: T
    taken: float


def undisturbed(measure: Callable[[], T]) -> list[Run[T]]:
    """Measure until a run is undisturbed; the last of those that are returned counts.

    After `ATTEMPTS` runs that is the one that was disturbed least, whatever its times are.
    """
    runs: list[Run[T]] = []
    while len(runs) < ATTEMPTS and not (runs and runs[-1].taken <= MOST):
        before, began = _taken(), time.perf_counter()
        found = measure()
        seconds = (os.cpu_count() or 1) * (time.perf_counter() - began)
        runs.append(Run(found, (_taken() - before) / seconds))
    least = min(runs, key=lambda one: one.taken)
    return [*(one for one in runs if one is not least), least]


def _taken() -> float:
    """Seconds of all processors that the host took so far; 0 where the kernel does not say."""
    try:
        words = _STAT.read_text(encoding="ascii").split("\n", 1)[0].split()
        return int(words[_STEAL]) / os.sysconf("SC_CLK_TCK")
    except (OSError, IndexError, ValueError):
        return 0.0
