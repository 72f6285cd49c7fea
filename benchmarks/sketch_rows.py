"""Rows of a sketch: evaluation, edits of the pattern, changes of values.

    python -m benchmarks.sketch_rows [ROWS]

Rectangles with eight constraints of different kinds each; medians on one thread.
"""

from __future__ import annotations

import sys

import numpy as np

from arael.loading import load_compiled
from arael.runtime.levels.compiled import KernelRows
from benchmarks.measure import timed


def rectangles(count: int) -> KernelRows:
    """Rows of `count` rectangles of four points each."""
    model = load_compiled("sketch")
    rows = KernelRows(model.layout, model.kernels, 8 * count)
    a, b, c, d = (8 * np.arange(count) + 2 * k for k in range(4))
    one = np.ones((count, 1))
    with rows.edit():
        rows.extend("Horizontal", np.c_[a, b])
        rows.extend("Vertical", np.c_[b, c])
        rows.extend("Parallel", np.c_[a, b, d, c])
        rows.extend("Perpendicular", np.c_[a, b, a, d])
        rows.extend("Distance", np.c_[a, b], one)
        rows.extend("PointLineDistance", np.c_[c, a, b], one)
        rows.extend("Angle", np.c_[a, b, a, d], one)
        rows.extend("EqualLength", np.c_[a, b, a, d])
    return rows


def main(count: int) -> None:
    """Print a line per measurement."""
    rows = rectangles(count // 8)
    x = np.random.default_rng(0).normal(size=rows.n)
    last = int(rows.instances()[-1])

    def rebuild() -> None:
        rows.set_on(0, False)
        rows.set_on(0, True)

    def add_and_remove() -> None:
        rows.remove(rows.add("Distance", [0, 2], [1.0]))

    actions = {
        "residuals and entries": lambda: rows.jacobian(x),
        "residuals": lambda: rows.evaluate(x),
        "the first row off and on: two whole patterns": rebuild,
        "a row at the end added and removed": add_and_remove,
        "a value changed": lambda: rows.set_data(last, 0, 1.0),
    }
    print(f"{rows.m} rows, {len(rows.indices)} entries; us, median (least - most)")
    for name, action in actions.items():
        print(f"{timed(action, 101).show(1e-6, 1):>24}  {name}")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 10_000)
