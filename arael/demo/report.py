"""Report of the demos about a scene and its solve."""

from __future__ import annotations

from collections.abc import Iterator

from arael.demo.scene_run import SceneRun
from arael.scenes import Scene


def scene_lines(scene: Scene) -> Iterator[str]:
    """Describe the scene."""
    seen = scene.observations
    yield (
        f"scene: {scene.config.trajectory}, {len(scene.pos)} poses, {len(scene.landmarks)} "
        f"landmarks, {len(seen)} observations, seed {scene.config.seed}"
    )
    wrong = int(seen.wrong.sum())
    if wrong:
        share = 100 * wrong / len(seen)
        yield (
            f"       {wrong} observations ({share:.0f} %) are wrong associations, "
            f"with {scene.config.wrong_scale:g} times the pixel noise"
        )


def solve_lines(run: SceneRun) -> Iterator[str]:
    """Describe the solve, pass by pass."""
    for one in run.result.passes:
        yield (
            f"pass {one.name}: {one.status} after {one.iterations} iterations, "
            f"cost {one.start_cost:.6g} -> {one.end_cost:.6g}, {1e3 * one.seconds:.1f} ms"
        )
    yield f"{run.parameters} parameters, linear solver: {run.result.plan}"
