"""Timing and the words of a report."""

from __future__ import annotations

import json
import os
import platform
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import scipy

import arael
from arael.compiler.build import compiler_version


@dataclass(frozen=True)
class Timing:
    """Seconds of several runs."""

    runs: tuple[float, ...]

    @property
    def median(self) -> float:
        """The middle run."""
        return statistics.median(self.runs)

    def show(self, unit: float, digits: int = 2) -> str:
        """Median and spread in `unit` seconds: ``3.1 (2.9-3.6)``."""
        low, high = min(self.runs), max(self.runs)
        return f"{self.median / unit:.{digits}f} ({low / unit:.{digits}f}-{high / unit:.{digits}f})"


def timed(action: Callable[[], object], runs: int, warm: int = 2) -> Timing:
    """Time `action`, after some runs that do not count."""
    for _ in range(warm):
        action()
    found = []
    for _ in range(runs):
        began = time.perf_counter()
        action()
        found.append(time.perf_counter() - began)
    return Timing(tuple(found))


def process(command: Sequence[str], env: dict[str, str], runs: int) -> Timing:
    """Time a command as a whole process."""
    return timed(
        lambda: subprocess.run(command, env=env, check=True, capture_output=True), runs, warm=1
    )


THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "RAYON_NUM_THREADS")


def environment(threads: int = 1, /, **changes: str) -> dict[str, str]:
    """The environment with as many BLAS threads and `changes`."""
    return {**os.environ, **dict.fromkeys(THREADS, str(threads)), **changes}


def child(
    module: str, *words: object, threads: int = 1, timeout: float = 300, **changes: str
) -> Any:
    """Run a module of this package in a process of its own; return the JSON of its last line."""
    done = subprocess.run(
        [sys.executable, "-m", f"benchmarks.{module}", *(str(w) for w in words)],
        env=environment(threads, **changes),
        check=True,
        capture_output=True,
        text=True,
        timeout=timeout,
        cwd=Path(__file__).parents[1],
        preexec_fn=pinned(threads),
    )
    return json.loads(done.stdout.strip().splitlines()[-1])


def pinned(threads: int) -> Callable[[], None] | None:
    """Keep a process to as many processors as it may have threads, where the system can."""
    if not hasattr(os, "sched_setaffinity"):
        return None
    allowed = sorted(os.sched_getaffinity(0))[-threads:]
    return lambda: os.sched_setaffinity(0, allowed)


def table(head: Sequence[str], rows: Sequence[Sequence[object]]) -> list[str]:
    """Lines of a Markdown table."""
    return [
        "| " + " | ".join(head) + " |",
        "|" + "---|" * len(head),
        *("| " + " | ".join(str(c) for c in row) + " |" for row in rows),
    ]


def machine() -> list[str]:
    """Lines that say where this was measured."""
    model = platform.processor() or platform.machine()
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.exists():
        for line in cpuinfo.read_text().splitlines():
            if line.startswith("model name"):
                model = line.partition(":")[2].strip()
                break
    return [
        f"- processor: {model}, {os.cpu_count()} cores",
        f"- {platform.system()}, Python {sys.version.split()[0]}, NumPy {np.__version__}, "
        f"SciPy {scipy.__version__}, arael {arael.__version__}",
        f"- C compiler: {compiler_version() or 'none'}",
    ]
