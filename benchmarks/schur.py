"""Factor and solve of the solvers that eliminate entities first, beside `sparse` and CHOLMOD."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import AraelError
from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.linear.analysis import analyse_order
from arael.runtime.linear.auto import make_solver
from arael.runtime.linear.compiled import LinearSolver, SparseSolver, reduce
from arael.runtime.linear.costs import predict
from arael.runtime.linear.planning import independent_set
from arael.runtime.linear.reduced import plan_reduced
from benchmarks.measure import child, table, timed
from benchmarks.systems import Plan

Array = NDArray[np.float64]

RUNS = 7
FAR_TOO_MANY = 10_000  # entities
SOLVERS = ("sparse", "cholmod", "schur", "schur_pcg")

Row = list[str]


def run(plan: Plan) -> list[str]:
    """Measure each structure in a process of its own; return the report's lines."""
    rows: list[Row] = []
    for name in list(STRUCTURES)[: 1 if plan.quick else None]:
        for threads in plan.threads:
            rows += child("schur", name, threads, threads=threads, timeout=600)
    return [
        "## schur",
        "",
        "One factorisation with new damping and one solve in milliseconds, fastest of "
        f"{RUNS} (median in parentheses), all solvers of a structure in one process in turn. "
        "Values are random, the diagonal dominates. `analysis` is done once a structure. "
        "`schur_pcg` iterates to 0.1 of the right-hand side.",
        "",
        *table(
            ("structure", "threads", "solver", "factor", "solve", "analysis", "predicted factor",
             "auto"),
            rows,
        ),
    ]  # fmt: skip


def measure(name: str, threads: int) -> list[Row]:
    """Rows of all solvers on a structure, f64 and f32."""
    pattern = STRUCTURES[name]()
    return [
        [f"{name}, {'f32' if single else 'f64'}", str(threads), *row]
        for single in (False, True)
        for row in _measure(pattern, single, threads)
    ]


def _measure(pattern: BlockPattern, single: bool, threads: int) -> list[Row]:
    dtype = np.float32 if single else np.float64
    values, diagonal = (part.astype(dtype) for part in values_on(pattern))
    b = np.random.default_rng(0).standard_normal(pattern.size).astype(dtype)
    taken = make_solver("auto", pattern, single).plan["solver"]
    rows: list[Row] = []
    for solver in SOLVERS:
        if solver == "cholmod" and (single or threads > 1):
            continue
        began = time.perf_counter()
        try:
            made = _made(solver, pattern, single)
        except AraelError:
            rows.append([solver, "not installed", "", "", "", ""])
            continue
        analysis = time.perf_counter() - began
        made.use_threads(threads)
        if made.factorise(values, diagonal):
            raise SystemExit(f"{solver} failed")
        factor = timed(lambda made=made: made.factorise(values, diagonal), RUNS, 1)
        solve = timed(lambda made=made: made.solved(b), RUNS, 1)
        rows.append(
            [
                f"{solver} ({made.plan['reduced_solver']})" if solver == "schur" else solver,
                f"{1e3 * min(factor.runs):.2f} ({1e3 * factor.median:.2f})",
                f"{1e3 * min(solve.runs):.2f} ({1e3 * solve.median:.2f})",
                f"{1e3 * analysis:.0f}",
                f"{made.plan['predicted_ms']:.2f}",
                "taken" if solver == taken else "",
            ]
        )
    return rows


def _made(name: str, pattern: BlockPattern, single: bool) -> LinearSolver:
    """Solver `name`; `sparse` in the order of the elimination where ordering would take minutes."""
    if name == "sparse" and pattern.block_count > FAR_TOO_MANY:
        reduced = plan_reduced(reduce(pattern, independent_set(pattern)), single)
        assert reduced is not None
        analysis = analyse_order(pattern, "eliminate_first", reduced.order())
        solver = SparseSolver(pattern, single, analysis=analysis)
        solver.plan["predicted_ms"] = predict(pattern, single, analysis)["sparse"].milliseconds
        return solver
    return make_solver(name, pattern, single)


def bundle_structure(cameras: int, points: int, observations: int) -> BlockPattern:
    """Cameras of 9 on a ring; points of 3, each seen by cameras around one of them.

    The number of cameras that see a point is geometric from two on, as in the public data sets, and
    they lie within a few times that number of places.
    """
    rng = np.random.default_rng(1)
    mean = observations / points
    seen = np.minimum(1 + rng.geometric(1 / (mean - 1), points), cameras)
    point = np.repeat(np.arange(points), seen)
    anchor = rng.integers(0, cameras, points)[point]
    spread = np.maximum(3, 2 * seen)[point]
    camera = (anchor + np.rint(rng.normal(0, spread)).astype(np.int64)) % cameras
    sizes = np.repeat(np.array([9, 3]), [cameras, points])
    return BlockPattern.from_pairs(sizes, camera, cameras + point)


def slam_structure(poses: int) -> BlockPattern:
    """The Hessian of the SLAM scene of the benchmarks."""
    import arael
    from arael.runtime.problem import Problem
    from arael.scenes.columns import columns
    from arael.scenes.config import benchmark_config
    from arael.scenes.fill import fill
    from arael.scenes.scene import make_scene

    model = arael.load("slam")
    instance = model()
    fill(instance, model.layout, columns(make_scene(benchmark_config(poses=poses))))
    compiled = model.compiled
    return Problem(compiled.layout, instance._store, compiled.kernels).structure.pattern


def values_on(pattern: BlockPattern) -> tuple[Array, Array]:
    """Random values and a diagonal that dominates them."""
    values = 0.1 * np.random.default_rng(0).standard_normal(pattern.value_count)
    columns = np.repeat(np.arange(pattern.block_count), np.diff(pattern.column_start))
    area = pattern.sizes[pattern.rows] * pattern.sizes[columns]
    ends = np.concatenate(([0], np.cumsum(np.abs(values))))
    sums = ends[pattern.value_start + area] - ends[pattern.value_start]
    total = np.bincount(pattern.rows, sums, pattern.block_count)
    total += np.bincount(columns, sums, pattern.block_count)
    return values, np.repeat(1 + total, pattern.sizes)


STRUCTURES: dict[str, Callable[[], BlockPattern]] = {
    "slam, 60 poses": lambda: slam_structure(60),
    "slam, 300 poses": lambda: slam_structure(300),
    "slam, 900 poses": lambda: slam_structure(900),
    "bundle, 49 cameras, 7776 points": lambda: bundle_structure(49, 7_776, 31_843),
    "bundle, 300 cameras, 50 000 points": lambda: bundle_structure(300, 50_000, 300_000),
}

if __name__ == "__main__":
    print(json.dumps(measure(sys.argv[1], int(sys.argv[2]))))
