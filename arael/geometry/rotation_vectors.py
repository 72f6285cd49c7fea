"""Rotation vectors: the axis times the angle; exponential and logarithm of rotation matrices."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from arael.geometry.arrays import Array, as_array
from arael.geometry.quaternions import quat_from_matrix, quat_log
from arael.geometry.rotations import skew


def rotation_from_vector(v: ArrayLike) -> Array:
    """Rotation matrices (..., 3, 3) of rotation vectors (..., 3) [rad]: the exponential map.

    Rodrigues' formula ``I + sin(a)/a [v]x + (1 - cos(a))/a^2 [v]x^2`` with a = |v|, written with
    sinc to be exact at zero too.
    """
    vectors = as_array(v, (3,), "v")
    angle = np.linalg.norm(vectors, axis=-1)[..., None, None]
    k = skew(vectors)
    # (1 - cos a) / a^2 = sinc(a / 2)^2 / 2; NumPy's sinc has pi in it.
    found: Array = (
        np.eye(3) + np.sinc(angle / np.pi) * k + 0.5 * np.sinc(angle / (2 * np.pi)) ** 2 * (k @ k)
    )
    return found


def rotation_vector(rotation: ArrayLike) -> Array:
    """Rotation vectors (..., 3) [rad], no longer than pi, of rotation matrices: the logarithm."""
    return quat_log(quat_from_matrix(rotation))
