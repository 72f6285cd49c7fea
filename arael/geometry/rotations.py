"""Euler angles and rotation matrices: ``R = Rz(yaw) Ry(pitch) Rx(roll)``."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from arael.geometry.arrays import Array, as_array, as_numbers


def rotation_matrix(ea: ArrayLike) -> Array:
    """Rotation matrices (..., 3, 3), body to world, of Euler angles.

    Parameters
    ----------
    ea : (..., 3) roll about x, pitch about y, yaw about z [rad]
    """
    angles = as_array(ea, (3,), "ea")
    sr, sp, sy = np.moveaxis(np.sin(angles), -1, 0)
    cr, cp, cy = np.moveaxis(np.cos(angles), -1, 0)
    rows = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def euler_angles(rotation: ArrayLike) -> Array:
    """Roll, pitch, yaw (..., 3) [rad] of rotation matrices (..., 3, 3).

    Pitch lies in [-pi/2, pi/2], roll and yaw in [-pi, pi]. At a pitch of +-90 degrees only the
    difference or the sum of roll and yaw is defined (gimbal lock): roll is then 0.
    """
    r = as_array(rotation, (3, 3), "rotation")
    level = np.hypot(r[..., 2, 1], r[..., 2, 2])
    locked = level < 1e-12
    roll = np.where(locked, 0.0, np.arctan2(r[..., 2, 1], r[..., 2, 2]))
    pitch = np.arctan2(-r[..., 2, 0], level)
    yaw = np.where(
        locked,
        np.arctan2(-r[..., 0, 1], r[..., 1, 1]),
        np.arctan2(r[..., 1, 0], r[..., 0, 0]),
    )
    return np.stack([roll, pitch, yaw], axis=-1)


def skew(v: ArrayLike) -> Array:
    """Matrices [v]x (..., 3, 3) of the cross product: ``skew(v) @ u = v x u``."""
    vectors = as_array(v, (3,), "v")
    x, y, z = np.moveaxis(vectors, -1, 0)
    o = np.zeros_like(x)
    return np.moveaxis(np.array([[o, -z, y], [z, o, -x], [-y, x, o]]), (0, 1), (-2, -1))


def vee(m: ArrayLike) -> Array:
    """Vectors (..., 3) of the skew-symmetric part of `m` (..., 3, 3): ``vee(skew(v)) = v``."""
    a = as_array(m, (3, 3), "m")
    found: Array = 0.5 * np.stack(
        [
            a[..., 2, 1] - a[..., 1, 2],
            a[..., 0, 2] - a[..., 2, 0],
            a[..., 1, 0] - a[..., 0, 1],
        ],
        axis=-1,
    )
    return found


def wrap_angle(angle: ArrayLike) -> Array:
    """The same angles [rad] in [-pi, pi)."""
    found: Array = (as_numbers(angle, "angle") + np.pi) % (2 * np.pi) - np.pi
    return found
