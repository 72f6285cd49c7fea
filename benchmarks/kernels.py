"""Nanoseconds per observation of the SLAM bearing, vectorised and not."""

from __future__ import annotations

import json
import os
import sys
import tempfile

from benchmarks.measure import Timing, child, table, timed

SCALAR = "-fno-tree-vectorize -fno-tree-slp-vectorize -fno-openmp-simd"
POSES = 300
RUNS = 40


def run() -> list[str]:
    """Measure in one process per build, alternating, and return the report's lines."""
    found: dict[tuple[str, str], list[dict[str, list[float]]]] = {}
    observations = 0
    with tempfile.TemporaryDirectory() as cache:
        for _ in range(3):
            for precision in ("f64", "f32"):
                for build, flags in (("vectorised", ""), ("scalar", SCALAR)):
                    env = {"ARAEL_CACHE_DIR": cache, "CFLAGS": flags}
                    measured = child("kernels", precision, **env)
                    observations = measured.pop("observations")
                    found.setdefault((precision, build), []).append(measured)
    rows = []
    for precision in ("f64", "f32"):
        times = {
            build: {
                what: Timing(tuple(t for run in found[precision, build] for t in run[what]))
                for what in ("linearise", "cost")
            }
            for build in ("vectorised", "scalar")
        }
        for what in ("linearise", "cost"):
            fast, slow = times["vectorised"][what], times["scalar"][what]
            unit = observations * 1e-9
            rows.append(
                (precision, what, fast.show(unit, 1), slow.show(unit, 1),
                 f"{slow.median / fast.median:.1f}")
            )  # fmt: skip
    return [
        "## kernels",
        "",
        f"SLAM bearing, {POSES} poses, {observations} observations, benchmark scene without wrong "
        "associations; `linearise` is everything a linearisation of the scene does: residuals, "
        "Jacobian, J'J, their accumulation into the blocks and what is emptied before, the few "
        "other constraints included; ns per observation, median (min-max).",
        "",
        *table(("precision", "kernel", "vectorised", "scalar build", "ratio"), rows),
    ]


def _measure(precision: str) -> dict[str, object]:
    import arael
    from arael.runtime.problem import Problem
    from arael.scenes.columns import columns
    from arael.scenes.config import benchmark_config
    from arael.scenes.fill import fill
    from arael.scenes.scene import make_scene

    model_class = arael.load("slam", precision=precision)
    model = model_class()
    fill(model, model_class.layout, columns(make_scene(benchmark_config(poses=POSES))))
    compiled = model_class.compiled
    problem = Problem(compiled.layout, model._store, compiled.kernels)
    number = [g.label for g in compiled.layout.groups].index("PointFrine.bearing")
    evaluation = problem.evaluation
    room = evaluation.room()
    return {
        "observations": len(problem.structure.active[number]),
        "linearise": timed(lambda: evaluation.linearised(room), RUNS).runs,
        "cost": timed(lambda: evaluation.group_cost(number), RUNS).runs,
    }


if __name__ == "__main__":
    json.dump(_measure(sys.argv[1]), sys.stdout)
    sys.stdout.write(os.linesep)
