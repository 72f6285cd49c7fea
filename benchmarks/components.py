"""Independent problems in one model, beside solving each alone: epochs of a GNSS receiver.

Four unknowns an epoch, position and clock, from six to ten pseudoranges, started at the Earth's
centre. Solved in one call, and one after the other through one model whose data is exchanged.
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.measure import child, table
from benchmarks.systems import Plan

Array = NDArray[np.float64]

MODEL = """
struct Satellite {
    pos: vec3
    range: real
    constraint pseudorange { (norm(pos - parent.pos) + parent.clock - range) / 5 }
}
struct Epoch {
    param pos: vec3
    param clock: real
    satellites: list of Satellite
}
root Track {
    epochs: list of Epoch
}
"""
COUNT, QUICK_COUNT = 1000, 50
RUNS = 5


def run(plan: Plan, picture: Path | None) -> list[str]:
    """Measure both, each in a process of its own; return the report's lines."""
    count = QUICK_COUNT if plan.quick else COUNT
    rows = []
    for threads in plan.threads:
        found = child("components", "together", count, threads, threads=threads)
        rows.append(_row(f"one model, {threads} t", count, found))
    rows.append(_row("one after the other", count, child("components", "alone", count)))
    return [
        "## components",
        "",
        f"{count} epochs of a GNSS receiver, 6 to 10 pseudoranges each, from the Earth's centre. "
        f"First: the first solve of the data, the model compiled before; again: the median of "
        f"{RUNS} solves from the same start. One after the other: one epoch in the model at a "
        f"time, its rows built before the clock starts, first solve.",
        "",
        *table(
            ("", "epochs", "first ms an epoch", "again ms an epoch", "attempts", "converged"), rows
        ),
    ]


def _row(name: str, count: int, found: Any) -> tuple[object, ...]:
    again = f"{1e3 * found['again'] / count:.4f}" if found["again"] else ""
    first = f"{1e3 * found['first'] / count:.4f}"
    return name, count, first, again, found["attempts"], found["converged"]


def scene(count: int) -> list[tuple[Array, Array]]:
    """Positions of satellites (n, 3) and pseudoranges (n,) of each epoch, in metres."""
    rng = np.random.default_rng(3)
    found = []
    for _ in range(count):
        up = rng.normal(size=3)
        up /= np.linalg.norm(up)
        seen = int(rng.integers(6, 11))
        ways = rng.normal(size=(seen, 3))
        ways /= np.linalg.norm(ways, axis=1)[:, None]
        ways = np.where((ways @ up)[:, None] < 0, -ways, ways)
        satellites = 6.371e6 * up + 2.2e7 * ways
        ranges = np.linalg.norm(satellites - 6.371e6 * up, axis=1) + rng.normal(0, 5, seen)
        found.append((satellites, ranges + 3e5 * rng.normal()))
    return found


def load() -> Any:
    """The model, compiled."""
    import arael

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "track.arael"
        path.write_text(MODEL, encoding="utf-8")
        return arael.load(path)


def filled(kind: Any, epochs: list[tuple[Array, Array]]) -> Any:
    """A model with some epochs in it, at the Earth's centre."""
    track = kind()
    for satellites, ranges in epochs:
        epoch = track.epochs.append(pos=[0, 0, 0], clock=0.0)
        epoch.satellites.extend(pos=satellites, range=ranges)
    return track


def together(count: int, threads: int) -> dict[str, object]:
    """All epochs in one model."""
    kind = load()
    filled(kind, scene(2)).solve()
    track = filled(kind, scene(count))
    seconds = []
    for _ in range(RUNS + 1):
        track.epochs.pos.value[:], track.epochs.clock.value[:] = 0, 0
        began = time.perf_counter()
        result = track.solve(num_threads=threads)
        seconds.append(time.perf_counter() - began)
    return {
        "first": seconds[0],
        "again": float(np.median(seconds[1:])),
        "attempts": int(result.components.iterations.max()),
        "converged": int(result.components.converged.sum()),
    }


def alone(count: int) -> dict[str, object]:
    """Each epoch in a model of its own."""
    kind = load()
    filled(kind, scene(1)).solve()
    seconds, attempts, converged = 0.0, 0, 0
    for epoch in scene(count):
        track = filled(kind, [epoch])
        began = time.perf_counter()
        result = track.solve()
        seconds += time.perf_counter() - began
        attempts, converged = max(attempts, result.iterations), converged + result.converged
    return {"first": seconds, "again": 0, "attempts": attempts, "converged": converged}


if __name__ == "__main__":
    if sys.argv[1] == "together":
        print(json.dumps(together(int(sys.argv[2]), int(sys.argv[3]))))
    else:
        print(json.dumps(alone(int(sys.argv[2]))))
