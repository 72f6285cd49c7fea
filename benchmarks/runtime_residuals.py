"""How long many small residuals given as text take: to derive, to solve first, to solve again."""

from __future__ import annotations

import json
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import arael
from benchmarks.measure import child, table
from benchmarks.systems import Plan

MODEL = """
struct Point {
    param pos: vec2
    constraint keep { (pos - pos.value) * 1e-3 }
}

root Chain {
    points: list of Point
}
"""
COUNT, QUICK_COUNT = 100, 10
AGAIN = 20
LOOP = ("linearise", "factor", "first_factor", "solve", "cost")


def run(plan: Plan, picture: Path | None = None) -> list[str]:
    """Measure each variant in a process of its own; return the report's lines."""
    count = QUICK_COUNT if plan.quick else COUNT
    found = {
        f"{precision}, {n} t": child("runtime_residuals", precision, n, count, threads=n)
        for n in plan.threads
        for precision in ("f64", "f32")
    }
    steps = next(iter(found.values()))
    return [
        "## residuals",
        "",
        f"A chain of {count + 1} points with {count} distances given as text. Milliseconds, "
        "medians; the first solve once.",
        "",
        *table(
            ["step", *found],
            [[step, *(f"{1e3 * one[step]:.2f}" for one in found.values())] for step in steps],
        ),
    ]


def measure(precision: str, threads: int, count: int) -> dict[str, float]:
    """Seconds of every step."""
    chain = _chain(precision, count)
    adding = []
    for k in range(count):
        a, b = f"points[{k}].pos", f"points[{k + 1}].pos"
        text = f"hypot({b}.x - {a}.x, {b}.y - {a}.y) - w * {1 + k % 3}"
        adding.append(_seconds(chain.residuals.add, text, label=f"d{k}", data={"w": 1.0}))
    first = _seconds(chain.solve, num_threads=threads)
    again, inner = [], []
    for k in range(AGAIN):
        chain.residuals["d3"].set_data(w=1.0 + 0.5 * (k % 2))
        began = time.perf_counter()
        timing = chain.solve(num_threads=threads).timing
        again.append(time.perf_counter() - began)
        inner.append(sum(timing.get(phase, 0.0) for phase in LOOP))
    exchanged, solved = [], []
    for k in range(AGAIN):
        at = k % (count - 1)
        text = f"norm(points[{at}].pos - points[{at + 2}].pos) - 1.7 * {1 + k % 3}"
        exchanged.append(_seconds(chain.residuals.add, text, label="extra"))
        solved.append(_seconds(chain.solve, num_threads=threads))
        chain.residuals.remove("extra")
    return {
        "parse and differentiate, each expression": statistics.median(adding),
        "first solve": first,
        "solve again after a dimension changed": statistics.median(again),
        "... of which linearisation, factorisation, solution and cost": statistics.median(inner),
        "add one more expression": statistics.median(exchanged),
        "solve again after it": statistics.median(solved),
    }


def _chain(precision: str, count: int) -> Any:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "chain.arael"
        path.write_text(MODEL, encoding="utf-8")
        chain: Any = arael.load(path, precision=precision)()  # type: ignore[arg-type]
    x = np.arange(count + 1)
    y = np.random.default_rng(0).normal(size=count + 1)
    chain.points.extend(pos=np.stack([x, y], axis=1))
    chain.residuals.add("points[0].pos", label="anchor")
    return chain


def _seconds(action: Callable[..., object], *words: object, **named: object) -> float:
    began = time.perf_counter()
    action(*words, **named)
    return time.perf_counter() - began


if __name__ == "__main__":
    if len(sys.argv) > 1:
        print(json.dumps(measure(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))))
    else:
        print("\n".join(run(Plan(threads=(1, 2)))))
