"""The residuals of ``slam.arael``, written once more in NumPy: an oracle that shares no code."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[Any]

GAMMA = 2 * np.sqrt(25) / np.pi


def starship(r: Array) -> Array:
    return GAMMA * np.arctan(r / GAMMA)


def matrix(ea: Array) -> Array:
    """Body-to-world rotations of roll, pitch, yaw (n, 3)."""
    return Rotation.from_euler("ZYX", ea[:, ::-1]).as_matrix()


def bearing(
    columns: dict[str, Array], pos: Array, ea: Array, landmarks: Array, scale: float = 1.0
) -> Array:
    """Bearing residuals (k, 2) of the columns' frines, in their order."""
    pose = columns["landmarks.frines.pose"]
    feature = columns["poses.info.features.offsets"][pose] + columns["landmarks.frines.feature"]
    sizes = np.diff(columns["landmarks.frines.offsets"])
    landmark = np.repeat(np.arange(len(sizes)), sizes)
    back = np.swapaxes(matrix(ea), 1, 2)[pose]
    body = np.einsum("kij,kj->ki", back, landmarks[landmark] - pos[pose])
    body = body - columns["poses.info.features.camera_pos"][feature]
    ray = np.einsum("kji,kj->ki", columns["poses.info.features.mf2r"][feature], body)
    angles = np.arctan2(ray[:, 1:], ray[:, :1])
    return starship(angles * columns["poses.info.features.isigma"][feature] * scale)


def gps(columns: dict[str, Array], pos: Array) -> Array:
    """GPS residuals (n, 3)."""
    raw = pos - columns["poses.info.gps.pos"]
    turned = np.einsum("kji,kj->ki", columns["poses.info.gps.cov_r"], raw)
    return starship(turned * columns["poses.info.gps.cov_isigma"])


def tilt(columns: dict[str, Array], ea: Array) -> Array:
    """Tilt residuals (n, 2)."""
    measured = np.column_stack([columns["poses.info.tilt_roll"], columns["poses.info.tilt_pitch"]])
    return (ea[:, :2] - measured) / np.deg2rad(0.25)


def odometry(columns: dict[str, Array], pos: Array, ea: Array) -> Array:
    """Odometry residuals (n - 1, 6)."""
    prev, cur = columns["pose_pairs.prev"], columns["pose_pairs.cur"]
    rotation = matrix(ea)
    back = np.swapaxes(rotation[prev], 1, 2)
    moved = np.einsum("kij,kj->ki", back, pos[cur] - pos[prev])
    pos_err = moved - columns["poses.info.delta_pos"][cur]
    expected = rotation[prev] @ matrix(columns["poses.info.delta_ea"][cur])
    error = np.swapaxes(expected, 1, 2) @ rotation[cur]
    ea_err = Rotation.from_matrix(error).as_euler("ZYX")[:, ::-1]
    return np.hstack(
        [
            pos_err * columns["poses.info.delta_pos_cov_isigma"][cur],
            ea_err * columns["poses.info.delta_ea_cov_isigma"][cur],
        ]
    )
