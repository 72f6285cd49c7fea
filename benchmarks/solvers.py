"""Milliseconds per iteration of each linear solver, on the same problem from the same start."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import arael
from benchmarks.measure import Timing, table

GRAPHS = {
    "M3500": ("pose_graph_2d", "pose_graph_2d/M3500.g2o"),
    "sphere2500": ("pose_graph_3d", "pose_graph_3d/sphere2500.g2o"),
    "parking-garage": ("pose_graph_3d", "pose_graph_3d/parking-garage.g2o"),
}
SOLVERS = ("sparse", "cholmod")
SHORT, LONG = 1, 4


def run() -> list[str]:
    """Measure and return the report's lines."""
    root = Path(os.environ.get("ARAEL_DATA", Path(__file__).parents[2] / "shared" / "data"))
    rows = []
    for name, (model, file) in GRAPHS.items():
        if not (root / file).is_file():
            rows.append((name, f"{file} not found; set ARAEL_DATA", "", ""))
            continue
        slopes = {solver: _slope(model, root / file, solver) for solver in SOLVERS}
        ratio = slopes["cholmod"].median / slopes["sparse"].median
        rows.append(
            (name, slopes["sparse"].show(1e-3), slopes["cholmod"].show(1e-3), f"{ratio:.2f}")
        )
    return [
        "## solvers",
        "",
        f"Milliseconds per iteration: the slope between {SHORT} and {LONG} iterations from the "
        "file's start, f64, one thread, median (min-max) of 5 slopes.",
        "",
        *table(("graph", "sparse", "cholmod", "cholmod / sparse"), rows),
    ]


def _slope(model: str, path: Path, solver: str) -> Timing:
    slopes = []
    for _ in range(5):
        seconds = []
        for iterations in (SHORT, LONG):
            instance: Any = arael.load(model)()
            arael.read(instance, path)
            result = instance.solve(
                solver=solver,
                max_iters=iterations,
                min_iters=iterations,
                patience=iterations,
                abs_precision=0.0,
                rel_precision=0.0,
            )
            seconds.append((sum(record["seconds"] for record in result.history), result.iterations))
        (short, n), (long, m) = seconds
        slopes.append((long - short) / (m - n))
    return Timing(tuple(slopes))
