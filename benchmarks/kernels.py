"""Nanoseconds per observation of the SLAM bearing, vectorised and not."""

from __future__ import annotations

import itertools
import json
import os
import sys
import tempfile
from collections.abc import Iterator

from benchmarks.measure import Timing, child, table, timed

SCALAR = "-fno-tree-vectorize -fno-tree-slp-vectorize -fno-openmp-simd"
SIZES = (60, 300)
"""Poses: what a linearisation moves stays in the caches of a core, or does not."""
RUNS = 40


def run() -> list[str]:
    """Measure in one process per build, alternating, and return the report's lines."""
    found: dict[tuple[int, str, str], list[dict[str, list[float]]]] = {}
    observations: dict[int, int] = {}
    with tempfile.TemporaryDirectory() as cache:
        for poses, precision, build, flags in _turns():
            env = {"ARAEL_CACHE_DIR": cache, "CFLAGS": flags}
            measured = child("kernels", precision, str(poses), **env)
            observations[poses] = measured.pop("observations")
            found.setdefault((poses, precision, build), []).append(measured)
    rows = []
    for poses, precision, what in itertools.product(SIZES, ("f64", "f32"), ("linearise", "cost")):
        fast, slow = (
            Timing(tuple(t for run in found[poses, precision, build] for t in run[what]))
            for build in ("vectorised", "scalar")
        )
        unit = observations[poses] * 1e-9
        rows.append(
            (poses, observations[poses], precision, what, fast.show(unit, 1),
             slow.show(unit, 1), f"{slow.median / fast.median:.1f}")
        )  # fmt: skip
    return [
        "## kernels",
        "",
        "SLAM bearing, benchmark scenes without wrong associations; `linearise` is everything a "
        "linearisation of the scene does: residuals, Jacobian, J'J, their accumulation into the "
        "blocks and what is emptied before, the few other constraints included; ns per "
        "observation, median (min-max).",
        "",
        *table(
            ("poses", "observations", "precision", "kernel", "vectorised",
             "scalar build", "ratio"),
            rows,
        ),
    ]  # fmt: skip


def _turns() -> Iterator[tuple[int, str, str, str]]:
    """(poses, precision, build, flags of the C compiler), three times."""
    builds = (("vectorised", ""), ("scalar", SCALAR))
    for _ in range(3):
        for poses, precision in itertools.product(SIZES, ("f64", "f32")):
            for build, flags in builds:
                yield poses, precision, build, flags


def _measure(precision: str, poses: int) -> dict[str, object]:
    import arael
    from arael.runtime.problem import Problem
    from arael.scenes.columns import columns
    from arael.scenes.config import benchmark_config
    from arael.scenes.fill import fill
    from arael.scenes.scene import make_scene

    model_class = arael.load("slam", precision=precision)
    model = model_class()
    fill(model, model_class.layout, columns(make_scene(benchmark_config(poses=poses))))
    compiled = model_class.compiled
    problem = Problem(compiled.layout, model._store, compiled.kernels)
    number = [g.label for g in compiled.layout.groups].index("PointFrine.bearing")
    evaluation = problem.evaluation
    workspace = evaluation.workspace()
    return {
        "observations": len(problem.structure.active[number]),
        "linearise": timed(lambda: evaluation.linearised(workspace), RUNS).runs,
        "cost": timed(lambda: evaluation.group_cost(number), RUNS).runs,
    }


if __name__ == "__main__":
    json.dump(_measure(sys.argv[1], int(sys.argv[2])), sys.stdout)
    sys.stdout.write(os.linesep)
