"""The SLAM demo over many seeds: attempts and errors, by default and by the reference's loop."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.measure import table
from benchmarks.systems import Plan

SEEDS, QUICK_SEEDS = 20, 2


def measure(seed: int) -> list[Any]:
    """Attempts in the demo, those of the reference's loop, error of poses and of landmarks."""
    import arael
    from arael.demo.scene_run import SolveOptions
    from arael.demo.slam import run_slam
    from arael.scenes import demo_config

    run = run_slam(demo_config(seed=seed), SolveOptions(verbose=False))
    again = _fresh(run).solve(arael.LmConfig.reference())
    status = "" if run.result.converged else run.result.status
    return [
        seed,
        run.result.iterations,
        again.iterations,
        run.errors.pose_rms,
        run.errors.landmark_relative_median,
        status,
    ]


def _fresh(run: Any) -> Any:
    """The model of a run at its start."""
    import arael
    from arael.scenes import columns, fill

    model = arael.load("slam")
    instance = model()
    fill(instance, model.layout, columns(run.scene))
    return instance


def run(plan: Plan, picture: Path | None) -> list[str]:
    """Lines of the chapter."""
    found = [measure(seed) for seed in range(1, 1 + (QUICK_SEEDS if plan.quick else SEEDS))]
    columns = list(zip(*found, strict=True))
    ours, before = np.array(columns[1]), np.array(columns[2])
    pose, landmark = np.array(columns[3]), np.array(columns[4])
    rows = [[s, a, b, f"{1e2 * p:.2f}", f"{1e2 * m:.2f}", w] for s, a, b, p, m, w in found]
    head = ["seed", "attempts", "attempts, reference", "pose RMS [cm]", "landmark median [%]", ""]
    return [
        "### SLAM demo over seeds",
        "",
        "All three passes; `reference` is `LmConfig.reference()` on the same scene. Errors are "
        "after alignment.",
        "",
        *table(head, rows),
        "",
        f"- converged: {sum(not w for w in columns[5])} of {len(found)}",
        f"- attempts: {ours.sum()} ({ours.min()}-{ours.max()} a seed), reference {before.sum()} "
        f"({before.min()}-{before.max()})",
        f"- pose RMS: at most {1e2 * pose.max():.2f} cm (aim: below 2)",
        f"- landmark median: at most {1e2 * landmark.max():.2f} %, below 2 % on "
        f"{int((landmark < 0.02).sum())} of {len(found)} seeds",
    ]
