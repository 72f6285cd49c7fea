"""One thread against two: the same problem in one process, the counts taking turns.

Time by the clock tells what a user gets; processor time tells what sharing costs, and does not
depend on who else uses the machine.
"""

from __future__ import annotations

import statistics
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from arael.runtime.parallel import compiled as pool
from arael.runtime.solve import minimise
from arael.scenes import benchmark_config, make_scene
from arael.solving import problem_of
from benchmarks import problems
from benchmarks.bundles import write_bundle
from benchmarks.measure import table
from benchmarks.systems import Plan

COUNTS = (1, 2)
UNSTOPPED = {"min_iters": 50, "patience": 50, "abs_precision": 0.0, "rel_precision": 0.0}


def run(plan: Plan, picture: Path | None) -> list[str]:
    """Measure, and return the report's lines."""
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for name, instance in _cases(Path(folder), plan.quick):
            rows += _measure(name, instance, 3 if plan.quick else 9)
    return [
        "## threads",
        "",
        f"Milliseconds of 3 iterations, medians of runs that take turns, {pool.cores()} cores: by "
        "the clock, and of the processor by all threads.",
        "",
        *table(["problem", "threads", "clock", "processor", "clock, ratio to one"], rows),
    ]


def _cases(folder: Path, quick: bool) -> Iterator[tuple[str, Any]]:
    for poses in (60,) if quick else (60, 300, 900):
        path = folder / f"slam-{poses}.npz"
        problems.write_scene(make_scene(benchmark_config(poses)), path)
        yield f"slam, {poses} poses", problems.KINDS["slam"].load(str(path))
    cameras, points = (20, 1000) if quick else (300, 50_000)
    path = folder / "bundle.txt"
    write_bundle(path, cameras, points)
    yield f"bundle, {cameras} cameras, {points} points", problems.KINDS["bundle"].load(str(path))


def _measure(name: str, instance: Any, runs: int) -> list[list[object]]:
    from arael.config import LmConfig

    problem = problem_of(instance)
    solver = problem.make_solver("auto")
    clock: dict[int, list[float]] = {count: [] for count in COUNTS}
    processor: dict[int, list[float]] = {count: [] for count in COUNTS}
    start = [state.copy() for state in problem.states]
    for _ in range(runs):
        for count in COUNTS:
            for entity, state in enumerate(start):
                stored = problem.layout.entities[entity].stored
                rows = len(problem.structure.system.blocks[entity].first)
                problem.evaluation.start_at(entity, state[:rows, :stored])
            solver.restart()
            config = LmConfig.reference(max_iters=3, num_threads=count, **UNSTOPPED)
            began, used = time.perf_counter(), time.process_time()
            minimise(problem, config, solver)
            clock[count].append(time.perf_counter() - began)
            processor[count].append(time.process_time() - used)
    one = statistics.median(clock[1])
    return [
        [
            name,
            count,
            f"{1e3 * statistics.median(clock[count]):.1f}",
            f"{1e3 * statistics.median(processor[count]):.1f}",
            f"{one / statistics.median(clock[count]):.2f}",
        ]
        for count in COUNTS
    ]
