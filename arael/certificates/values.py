"""Rotations and positions of columns of parameters, and back."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arael.geometry import euler_angles, quat_from_matrix, quat_to_matrix, rotation_matrix

Floats = NDArray[np.float64]


def planar(angle: Floats) -> Floats:
    """(n, 2, 2) rotations of the plane."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([np.stack([c, -s], axis=-1), np.stack([s, c], axis=-1)], axis=-2)


def matrices(quaternion: Floats) -> Floats:
    """(n, 3, 3) rotations of quaternions of any length."""
    length = np.linalg.norm(quaternion, axis=-1, keepdims=True)
    return np.asarray(quat_to_matrix(quaternion / np.where(length > 0, length, 1.0)))


def rotations_of(kind: str, stored: Floats) -> Floats:
    """(rows, d, d) of the stored scalars of a kind of parameter."""
    if kind == "angle":
        return planar(stored)
    if kind == "euler":
        return np.asarray(rotation_matrix(stored))
    return matrices(stored[:, 3:7] if kind == "transform" else stored)


def positions_of(kind: str, stored: Floats) -> Floats:
    """(rows, d) of the stored scalars of a kind of parameter."""
    return stored[:, :3] if kind == "transform" else stored


def put_rotations(kind: str, stored: Floats, rows: NDArray[np.int64], turned: Floats) -> None:
    """Write rotations (k, d, d) into rows of a column."""
    if kind == "angle":
        stored[rows] = np.arctan2(turned[:, 1, 0], turned[:, 0, 0])
    elif kind == "euler":
        stored[rows] = euler_angles(turned)
    elif kind == "transform":
        stored[rows, 3:7] = quat_from_matrix(turned)
    else:
        stored[rows] = quat_from_matrix(turned)


def put_positions(kind: str, stored: Floats, rows: NDArray[np.int64], moved: Floats) -> None:
    """Write positions (k, d) into rows of a column."""
    if kind == "transform":
        stored[rows, :3] = moved
    else:
        stored[rows] = moved
