"""Visual-inertial SLAM with half of the data associations wrong."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.demo.landmark_table import LandmarkLine, landmark_lines, spread
from arael.demo.report import scene_lines, solve_lines
from arael.demo.scene_run import DENSE_LIMIT, SceneRun, SolveOptions, solve_scene
from arael.demo.uncertainty import ellipsoid_axes, relative_covariances
from arael.geometry import rotation_matrix
from arael.plot.figure import beside, save
from arael.plot.scene import View, scene_figure
from arael.plot.sparsity import sparsity_figure
from arael.scenes import SceneConfig
from arael.scenes.evaluate import Errors, errors_against_truth, motions, rigid, seen_from

Array = NDArray[np.float64]
Index = NDArray[np.int64]

SHOWN = 12
"""Landmarks listed in the report."""
ALL_LIMIT = 3000
"""With more parameters, only the uncertainty of the listed landmarks is computed."""


@dataclass(frozen=True)
class SlamRun(SceneRun):
    """A solved SLAM scene."""

    @cached_property
    def landmarks(self) -> Array:
        """Solved landmark positions (m, 3) [m]."""
        return np.array(self.instance.landmarks.pos.value, dtype=np.float64)

    @cached_property
    def errors(self) -> Errors:
        """Errors against the truth."""
        scene = self.scene
        return errors_against_truth(self.poses, self.landmarks, scene.pos, scene.landmarks)

    @cached_property
    def local_errors(self) -> Array:
        """Error (m,) of each landmark in the frame of its closest pose [m], without alignment."""
        scene, closest = self.scene, self.errors.closest
        found = seen_from(closest, self.poses, self.rotations, self.landmarks)
        true = seen_from(closest, scene.pos, rotation_matrix(scene.ea), scene.landmarks)
        errors: Array = np.linalg.norm(found - true, axis=1)
        return errors

    @cached_property
    def motion_errors(self) -> tuple[Array, Array]:
        """Errors (n-1,) of the motion from pose to pose: position [m] and attitude [rad]."""
        found = motions(self.poses, self.rotations)
        true = motions(self.scene.pos, rotation_matrix(self.scene.ea))
        pos, ea = (np.linalg.norm(f - t, axis=1) for f, t in zip(found, true, strict=True))
        return pos, ea

    @cached_property
    def frines(self) -> Index:
        """Observations of each landmark (m,)."""
        count = len(self.scene.landmarks)
        return np.bincount(self.scene.observations.landmark, minlength=count)

    @cached_property
    def known(self) -> Index:
        """Landmarks whose uncertainty is computed."""
        if self.parameters > DENSE_LIMIT:
            return np.zeros(0, dtype=np.int64)
        if self.parameters <= ALL_LIMIT:
            return np.arange(len(self.landmarks))
        return spread(self.local_errors / self.errors.distance, SHOWN)

    @cached_property
    def covariances(self) -> Array:
        """Covariances (k, 3, 3) of the landmarks `known`, relative to their closest pose [m^2]."""
        pose, landmark = self._first_parameters()
        closest = self.errors.closest[self.known]
        return relative_covariances(self.hessian, landmark[self.known], pose[closest])

    def table(self) -> list[LandmarkLine]:
        """Error and uncertainty of the landmarks `known`."""
        axes = ellipsoid_axes(self.covariances)
        distance = self.errors.distance
        return landmark_lines(self.local_errors, distance, self.known, axes, self.frines)

    def _first_parameters(self) -> tuple[Index, Index]:
        """First parameter of each pose's and each landmark's position."""
        first: dict[str, Index] = {}
        start = 0
        for entity in self.layout.entities:
            count = len(self.instance[entity.table])
            first[entity.table] = start + entity.tangent * np.arange(count)
            start += entity.tangent * count
        return first["poses"], first["landmarks"]


def run_slam(config: SceneConfig, options: SolveOptions | None = None) -> SlamRun:
    """Generate and solve the scene of `config`."""
    return SlamRun(**vars(solve_scene("slam", config, options or SolveOptions())))


def report(run: SlamRun) -> Iterator[str]:
    """Lines of text: the scene, the solve, errors against the truth, uncertainties."""
    yield from scene_lines(run.scene)
    yield from solve_lines(run)
    errors = run.errors
    start = errors_against_truth(
        run.scene.start_pos, run.scene.start_landmarks, run.scene.pos, run.scene.landmarks
    )
    yield ""
    yield "errors against the truth"
    yield (
        f"  poses: RMS {errors.pose_rms:.4f} m after similarity alignment "
        f"(start {start.pose_rms:.4f} m), scale {errors.scale:.4f}"
    )
    yield (
        f"  landmarks: median {100 * errors.landmark_relative_median:.2f} % of the distance to the "
        f"closest pose after rigid alignment (start {100 * start.landmark_relative_median:.2f} %), "
        f"{100 * errors.scaled_relative_median:.2f} % with the scale taken out"
    )
    pos, ea = run.motion_errors
    spread_pos, spread_ea = _median_max(1e3 * pos, "mm"), _median_max(np.rad2deg(ea), "deg")
    yield f"  motion from pose to pose: {spread_pos}; {spread_ea}"
    local = 100 * run.local_errors / errors.distance
    yield f"  landmarks as seen from their closest pose: {_median_max(local, '%')}"
    offset = np.linalg.norm(run.poses - run.scene.pos, axis=1).mean()
    yield f"  poses before alignment: mean {offset:.3f} m, mostly the offset of all GPS fixes"
    yield f"  largest robust cost of a bearing residual: {run.bearing_costs.max():.2f} (bound 25)"
    if not len(run.known):
        yield f"uncertainties are left out: more than {DENSE_LIMIT} parameters"
        return
    yield ""
    yield "landmarks from the best to the worst as seen from their closest pose, one-sigma axes"
    shown = set(spread(run.local_errors / errors.distance, SHOWN).tolist())
    lines = sorted((x for x in run.table() if x.index in shown), key=lambda x: x.relative)
    yield from (f"  {line}" for line in lines)


def _median_max(values: Array, unit: str) -> str:
    return f"median {np.median(values):.3f}, largest {values.max():.3f} {unit}"


def summary(run: SlamRun) -> dict[str, Any]:
    """Figures of a run, as plain data."""
    return {
        "observations": len(run.scene.observations),
        "wrong_observations": int(run.scene.observations.wrong.sum()),
        "parameters": run.parameters,
        "pose_rms": run.errors.pose_rms,
        "scale": run.errors.scale,
        "landmark_relative_median": run.errors.landmark_relative_median,
        "landmark_relative_median_scaled": run.errors.scaled_relative_median,
        "landmark_local_median": float(np.median(run.local_errors / run.errors.distance)),
        "largest_bearing_cost": float(run.bearing_costs.max()),
    }


def plot(run: SlamRun, path: Path) -> list[str]:
    """Draw the scene into `path`, and the Hessian into a second file; return the files."""
    scene = run.scene
    aligned = rigid(run.poses, scene.pos)
    covariances = np.full((len(run.landmarks), 3, 3), np.nan)
    if len(run.known):
        covariances[run.known] = aligned.rotation @ run.covariances @ aligned.rotation.T
    view = View(
        true_poses=scene.pos,
        start_poses=scene.start_pos,
        poses=aligned.apply(run.poses),
        true_landmarks=scene.landmarks,
        landmarks=aligned.apply(run.landmarks),
        covariances=covariances,
        title=f"{scene.config.trajectory}: {len(scene.pos)} poses, "
        f"{len(scene.landmarks)} landmarks, {len(scene.observations)} observations",
    )
    poses = run.layout.entities[0].tangent * len(scene.pos)
    groups = [("poses", poses), ("landmarks", run.parameters - poses)]
    pattern = sparsity_figure(*run.pattern, run.parameters, groups)
    return [save(scene_figure(view), path), save(pattern, beside(path, "hessian"))]
