"""Conversion of rotations between their representations in data.

Frames and signs: ``R = Rz(yaw) Ry(pitch) Rx(roll)`` maps body to world; quaternions are unit,
scalar first (w, x, y, z). Formulas: J. Diebel, "Representing Attitude" (2006), sections 5.6 and 6.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

# Tolerance for norms (and orthonormality of matrices) due to rounding in files.
UNIT_TOLERANCE = 1e-3


def matrix_from_euler(euler: Array) -> Array:
    """(..., 3) roll, pitch, yaw [rad] -> (..., 3, 3)."""
    sr, sp, sy = np.moveaxis(np.sin(euler), -1, 0)
    cr, cp, cy = np.moveaxis(np.cos(euler), -1, 0)
    return _matrix(
        (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        (-sp, cp * sr, cp * cr),
    )


def matrix_from_quaternion(q: Array) -> Array:
    """(..., 4) unit -> (..., 3, 3)."""
    w, x, y, z = np.moveaxis(q, -1, 0)
    return _matrix(
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )


def _matrix(*rows: tuple[Array, ...]) -> Array:
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def euler_from_matrix(m: Array) -> Array:
    """(..., 3, 3) -> (..., 3) roll, pitch, yaw [rad], pitch in [-pi/2, pi/2].

    At pitch = +-pi/2 only yaw -+ roll is determined; roll is taken as 0 there.
    """
    flat = np.hypot(m[..., 0, 0], m[..., 1, 0])
    pitch = np.arctan2(-m[..., 2, 0], flat)
    locked = flat < 1e-12
    roll = np.where(locked, 0.0, np.arctan2(m[..., 2, 1], m[..., 2, 2]))
    yaw = np.where(
        locked,
        np.arctan2(-m[..., 0, 1], m[..., 1, 1]),
        np.arctan2(m[..., 1, 0], m[..., 0, 0]),
    )
    return np.stack([roll, pitch, yaw], axis=-1)


def quaternion_from_matrix(m: Array) -> Array:
    """(..., 3, 3) -> (..., 4), w >= 0.

    The column of the 4 x 4 matrix 4 q q' with the largest diagonal, which avoids cancellation
    (S. W. Shepperd, "Quaternion from Rotation Matrix", 1978).
    """
    a, b, c = m[..., 0, 0], m[..., 1, 1], m[..., 2, 2]
    wx, wy, wz = (
        m[..., 2, 1] - m[..., 1, 2],
        m[..., 0, 2] - m[..., 2, 0],
        m[..., 1, 0] - m[..., 0, 1],
    )
    xy, xz, yz = (
        m[..., 0, 1] + m[..., 1, 0],
        m[..., 0, 2] + m[..., 2, 0],
        m[..., 1, 2] + m[..., 2, 1],
    )
    products = _matrix(
        (1 + a + b + c, wx, wy, wz),
        (wx, 1 + a - b - c, xy, xz),
        (wy, xy, 1 - a + b - c, yz),
        (wz, xz, yz, 1 - a - b + c),
    )
    largest = np.argmax(np.diagonal(products, axis1=-2, axis2=-1), axis=-1)
    q = np.take_along_axis(products, largest[..., None, None], axis=-1)[..., 0]
    q = q / np.linalg.norm(q, axis=-1, keepdims=True)
    return np.asarray(np.where(q[..., :1] < 0, -q, q))


def quaternion_from_euler(euler: Array) -> Array:
    """(..., 3) roll, pitch, yaw [rad] -> (..., 4)."""
    (sr, sp, sy), (cr, cp, cy) = (np.moveaxis(f(euler / 2), -1, 0) for f in (np.sin, np.cos))
    return np.stack(
        [
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        ],
        axis=-1,
    )


def quaternion_from_vector(v: Array) -> Array:
    """(..., 3) rotation vectors [rad] -> (..., 4)."""
    half = 0.5 * np.linalg.norm(v, axis=-1, keepdims=True)
    # sin(h) / (2 h) without 0 / 0; numpy's sinc is normalised by pi.
    return np.concatenate([np.cos(half), 0.5 * np.sinc(half / np.pi) * v], axis=-1)


def vector_from_quaternion(q: Array) -> Array:
    """(..., 4) unit -> (..., 3) rotation vectors [rad] of at most pi."""
    q = np.where(q[..., :1] < 0, -q, q)
    length = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    angle = 2 * np.arctan2(length, q[..., :1])
    small = length < 1e-150
    return np.where(small, 2.0, angle / np.where(small, 1.0, length)) * q[..., 1:]


def is_unit(q: Array) -> NDArray[np.bool_]:
    """Whether quaternions (..., 4) are unit up to the rounding of a data file."""
    return np.asarray(np.abs(np.linalg.norm(q, axis=-1) - 1) <= UNIT_TOLERANCE)


def normalised(q: Array) -> Array:
    """Return unit quaternions; those that are already unit to the last bits are unchanged."""
    square = (q * q).sum(axis=-1, keepdims=True)
    eps = np.finfo(q.dtype).eps
    return np.where(np.abs(square - 1) <= 4 * eps, q, q / np.sqrt(square))


def is_rotation(m: Array) -> NDArray[np.bool_]:
    """Whether matrices (..., 3, 3) are rotations up to the rounding of a data file."""
    off = np.abs(m @ np.swapaxes(m, -1, -2) - np.eye(3)).max(axis=(-1, -2))
    return np.asarray((off <= UNIT_TOLERANCE) & (np.linalg.det(m) > 0))
