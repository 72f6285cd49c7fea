"""Localization in a known map, with half of the data associations wrong."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.demo.report import scene_lines, solve_lines
from arael.demo.scene_run import DENSE_LIMIT, SceneRun, SolveOptions, solve_scene
from arael.plot.figure import beside, save
from arael.plot.scene import View, scene_figure
from arael.plot.sparsity import sparsity_figure
from arael.scenes import SceneConfig
from arael.scenes.evaluate import rms_distance

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LocalizationRun(SceneRun):
    """A solved localization scene. The map determines the frame, so no alignment is needed."""

    @cached_property
    def pose_rms(self) -> float:
        """RMS position error of the poses [m]."""
        return rms_distance(self.poses, self.scene.pos)

    @cached_property
    def sigma(self) -> Array:
        """One-sigma uncertainty (n, 3) of the poses' x, y and z [m]."""
        covariance = 2 * np.linalg.inv(self.hessian)
        variances = np.diag(covariance).reshape(len(self.poses), -1)[:, :3]
        sigma: Array = np.sqrt(variances)
        return sigma

    @property
    def half_bandwidth(self) -> int:
        """Half-bandwidth of the Hessian, in scalars."""
        rows, columns = self.pattern
        size = self.parameters // len(self.poses)
        return int(size * (np.abs(rows // size - columns // size).max() + 1) - 1)


def run_localization(config: SceneConfig, options: SolveOptions | None = None) -> LocalizationRun:
    """Generate and solve the scene of `config`."""
    return LocalizationRun(**vars(solve_scene("localization", config, options or SolveOptions())))


def report(run: LocalizationRun) -> Iterator[str]:
    """Lines of text: the scene, the solve, errors against the truth."""
    yield from scene_lines(run.scene)
    yield from solve_lines(run)
    start = rms_distance(run.scene.start_pos, run.scene.pos)
    yield ""
    yield "errors against the truth"
    yield f"  poses: RMS {run.pose_rms:.4f} m (start {start:.4f} m)"
    yield f"  largest robust cost of a bearing residual: {run.bearing_costs.max():.2f} (bound 25)"
    if run.parameters <= DENSE_LIMIT:
        sigma = np.median(run.sigma, axis=0)
        yield "  median one-sigma of x, y, z: " + ", ".join(f"{s:.4f}" for s in sigma) + " m"
    yield f"  half-bandwidth of the Hessian: {run.half_bandwidth}"


def summary(run: LocalizationRun) -> dict[str, Any]:
    """Figures of a run, as plain data."""
    return {
        "observations": len(run.scene.observations),
        "wrong_observations": int(run.scene.observations.wrong.sum()),
        "parameters": run.parameters,
        "pose_rms": run.pose_rms,
        "half_bandwidth": run.half_bandwidth,
        "largest_bearing_cost": float(run.bearing_costs.max()),
    }


def plot(run: LocalizationRun, path: Path) -> list[str]:
    """Draw the scene into `path`, and the Hessian into a second file; return the files."""
    scene = run.scene
    view = View(
        true_poses=scene.pos,
        start_poses=scene.start_pos,
        poses=run.poses,
        true_landmarks=scene.landmarks,
        landmarks=None,
        covariances=None,
        title=f"{scene.config.trajectory}: {len(scene.pos)} poses in a map of "
        f"{len(scene.landmarks)} landmarks",
    )
    pattern = sparsity_figure(*run.pattern, run.parameters)
    return [save(scene_figure(view), path), save(pattern, beside(path, "hessian"))]
