"""Attempts and time from each start of the public pose graphs: ``python -m benchmarks.starts``."""

from __future__ import annotations

import statistics
from pathlib import Path
from typing import Any

import arael
from arael.starts import WAYS, How
from benchmarks.cases import DATA
from benchmarks.measure import machine, table
from benchmarks.problems import pose_graph_model

RUNS = 5


def measure(file: Path, how: How) -> list[Any]:
    """A row: cost at the start, attempts, cost at the end, milliseconds of start and solve."""
    times = []
    for _ in range(RUNS):
        graph = arael.load(pose_graph_model(file))()
        graph.read(file)
        start = arael.initialise(graph, how)
        result = graph.solve()
        times.append((start.seconds * 1e3, result.seconds * 1e3))
    ms = [f"{statistics.median(column):.1f}" for column in zip(*times, strict=True)]
    begins = f"{start.costs[start.chosen]:.6g}"
    name = how if start.chosen == how else f"{how}: {start.chosen}"
    end = f"{result.end_cost:.4f}" if result.converged else f"{result.end_cost:.4f} {result.status}"
    return [file.stem, name, begins, result.iterations, end, *ms]


def main() -> None:
    """Print a table."""
    files = sorted(DATA.glob("pose_graph_?d/*.g2o"))
    head = (
        "file",
        "start",
        "cost there",
        "attempts",
        "cost at the end",
        "start [ms]",
        "solve [ms]",
    )
    rows = [measure(file, how) for file in files for how in WAYS]
    print("\n".join([*machine(), "", *table(head, rows)]))


if __name__ == "__main__":
    main()
