"""A scene as columns by path, for bulk loading into models."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

from arael.scenes.scene import Scene
from arael.scenes.sensors import GPS_SIGMA

Columns = dict[str, NDArray[np.generic]]


def columns(scene: Scene, model: Literal["slam", "localization"] = "slam") -> Columns:
    """Columns of `scene` for the standard model of that name.

    Keys are paths of the model (``poses.info.delta_pos``, ``landmarks.frines.pose``); lists within
    rows are concatenated under them, with their bounds in ``<path>.offsets`` (rows + 1). A feature
    index is relative to its pose. In ``localization`` the landmarks are the true ones and there is
    no GPS.
    """
    known = model == "localization"
    count = len(scene.pos)
    out: Columns = {
        "poses.pos": scene.start_pos,
        "poses.ea": scene.start_ea,
        **_pose_info(scene),
        **_features(scene),
        "landmarks.pos": scene.landmarks if known else scene.start_landmarks,
        **_frines(scene),
        "pose_pairs.prev": np.arange(count - 1),
        "pose_pairs.cur": np.arange(1, count),
    }
    return out if known else {**out, **_gps(scene)}


def _pose_info(scene: Scene) -> Columns:
    sensors, count = scene.sensors, len(scene.pos)
    identity = np.tile(np.eye(3), (count, 1, 1))
    return {
        "poses.info.delta_pos": sensors.delta_pos,
        "poses.info.delta_ea": sensors.delta_ea,
        "poses.info.delta_pos_cov_r": identity,
        "poses.info.delta_pos_cov_isigma": 1 / sensors.delta_pos_sigma,
        "poses.info.delta_ea_cov_r": identity.copy(),
        "poses.info.delta_ea_cov_isigma": 1 / sensors.delta_ea_sigma,
        "poses.info.tilt_roll": sensors.tilt[:, 0],
        "poses.info.tilt_pitch": sensors.tilt[:, 1],
    }


def _gps(scene: Scene) -> Columns:
    count = len(scene.pos)
    return {
        "poses.info.gps": np.ones(count, dtype=bool),
        "poses.info.gps.pos": scene.sensors.gps,
        "poses.info.gps.cov_r": np.tile(np.eye(3), (count, 1, 1)),
        "poses.info.gps.cov_isigma": np.full((count, 3), 1 / GPS_SIGMA),
    }


def _features(scene: Scene) -> Columns:
    seen = scene.observations
    order, offsets, _ = _grouped_by_pose(scene)
    return {
        "poses.info.features.offsets": offsets,
        "poses.info.features.pixel": seen.pixel[order],
        "poses.info.features.mf2r": seen.mf2r[order],
        "poses.info.features.camera_pos": seen.camera_pos[order],
        "poses.info.features.isigma": seen.isigma[order],
    }


def _frines(scene: Scene) -> Columns:
    seen = scene.observations
    _, _, within = _grouped_by_pose(scene)
    return {
        "landmarks.frines.offsets": _offsets(seen.landmark, len(scene.landmarks)),
        "landmarks.frines.pose": seen.pose,
        "landmarks.frines.feature": within,
    }


def _grouped_by_pose(scene: Scene) -> tuple[NDArray[np.int64], ...]:
    """Order of the observations by pose, bounds of each pose's, and their number within it."""
    pose = scene.observations.pose
    order = np.argsort(pose, kind="stable")
    offsets = _offsets(pose, len(scene.pos))
    within = np.empty(len(pose), dtype=np.int64)
    within[order] = np.arange(len(pose)) - offsets[pose[order]]
    return order, offsets, within


def _offsets(owner: NDArray[np.int64], count: int) -> NDArray[np.int64]:
    return np.concatenate([[0], np.cumsum(np.bincount(owner, minlength=count))])
