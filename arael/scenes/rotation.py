"""Euler angles and rotation matrices, many at a time: ``R = Rz(yaw) Ry(pitch) Rx(roll)``."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def rotation_matrices(ea: Array) -> Array:
    """Rotation matrices (n, 3, 3), body to world, of `ea` (n, 3): roll, pitch, yaw [rad]."""
    (sr, sp, sy), (cr, cp, cy) = np.sin(ea).T, np.cos(ea).T
    rows = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    return np.moveaxis(np.array(rows), -1, 0)


def euler_angles(rotation: Array) -> Array:
    """Roll, pitch, yaw (n, 3) [rad] of `rotation` (n, 3, 3); pitch in [-pi/2, pi/2]."""
    roll = np.arctan2(rotation[:, 2, 1], rotation[:, 2, 2])
    pitch = -np.arcsin(np.clip(rotation[:, 2, 0], -1.0, 1.0))
    yaw = np.arctan2(rotation[:, 1, 0], rotation[:, 0, 0])
    return np.column_stack([roll, pitch, yaw])
