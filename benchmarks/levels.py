"""Exact rows of chains of rectangles: solves after a dimension changed, and drags.

``python -m benchmarks.levels`` prints medians in milliseconds.
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from arael.loading import load_compiled
from arael.runtime.levels.compiled import KernelRows, Levels

MODEL = """
struct Point { param pos: vec2 }
struct Distance {
    a: ref Point in root.points
    b: ref Point in root.points
    value: real
    constraint holds { norm(b.pos - a.pos) - value }
}
root Rows {
    points: list of Point
    distances: list of Distance
}
"""


def chain(model: Any, count: int) -> tuple[KernelRows, Any, Any, Any]:
    """Rectangles side by side, each with a diagonal; the first two points are fixed."""
    k = np.arange(count)
    edges = [(2 * k, 2 * k + 2), (2 * k + 1, 2 * k + 3), (2 * k + 2, 2 * k + 3), (2 * k, 2 * k + 3)]
    pairs = np.concatenate([np.stack(edge, 1) for edge in edges])
    points = np.arange(2 * count + 2)
    x = np.stack([points // 2, points % 2], 1).astype(float)
    lengths = np.hypot(*(x[pairs[:, 1]] - x[pairs[:, 0]]).T)
    rows = KernelRows(model.layout, model.kernels, x.size)
    numbers = rows.extend("Distance", 2 * pairs, {"value": lengths})
    fixed = np.zeros(x.size, bool)
    fixed[:4] = True
    return rows, numbers, x.ravel(), fixed


def drags(model: Any, links: int) -> None:
    """A chain of links that can all turn, its end dragged around a circle in 60 frames."""
    k = np.arange(links)
    turns = np.stack([np.cos(0.5 * (-1.0) ** k), np.sin(0.5 * (-1.0) ** k)], 1)
    home = np.concatenate([[0, 0], np.cumsum(turns, 0).ravel()])
    rows = KernelRows(model.layout, model.kernels, home.size)
    rows.extend("Distance", np.stack([2 * k, 2 * k + 2], 1), {"value": np.ones(links)})
    fixed = np.arange(home.size) < 2
    levels, x, end = Levels(rows), home.copy(), home.size - 2
    times, made = [], []
    for angle in np.linspace(0, 2 * np.pi, 61)[1:]:
        target = home[end:] + np.array([-3 * (1 - np.cos(angle)), 3 * np.sin(angle)])
        begin = time.perf_counter()
        outcome = levels.drag(x, [end, end + 1], target, home, fixed=fixed)
        times.append(1e3 * (time.perf_counter() - begin))
        made.append(levels.linearisations)
        assert outcome.solved
    print(
        f"{links:5d} {np.median(times):9.2f} {max(times):9.2f} {np.median(made):9.0f} "
        f"{np.abs(x - home).max():12.1e}"
    )


def milliseconds(call: Any) -> float:
    begin = time.perf_counter()
    call()
    return 1e3 * (time.perf_counter() - begin)


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "rows.arael")
        path.write_text(MODEL, encoding="utf-8")
        model = load_compiled(path)
    print("rows   analysis  solve  solve again  evaluate  steps")
    for count in (25, 125, 500, 2500):
        rows, numbers, x, fixed = chain(model, count)
        levels = Levels(rows)
        analysis = milliseconds(lambda: levels.solve(x, 1e-9, fixed=fixed))  # noqa: B023
        x[4:] += 1e-4 * np.random.default_rng(0).normal(size=len(x) - 4)
        first = milliseconds(lambda: levels.solve(x, 1e-9, fixed=fixed))  # noqa: B023
        middle = numbers[count // 2 :: count]
        again, steps = [], 0
        for t in range(31):
            width = 1 + 0.02 * (t % 2)
            for row, value in zip(middle, (width, width, 1, np.hypot(width, 1)), strict=True):
                rows.set_data(int(row), "value", value)
            begin = time.perf_counter()
            outcome = levels.solve(x, 1e-9, fixed=fixed)
            again.append(1e3 * (time.perf_counter() - begin))
            assert outcome.solved
            steps = outcome.steps
        evaluate = np.median([milliseconds(lambda: rows.evaluate(x)) for _ in range(21)])  # noqa: B023
        print(
            f"{rows.m:6d} {analysis:8.2f} {first:7.3f} {np.median(again):9.3f} "
            f"{evaluate:10.4f} {steps:6d}"
        )
    print("links    frame   slowest  linearisations  from home in the end")
    for links in (20, 100, 500):
        drags(model, links)


if __name__ == "__main__":
    main()
