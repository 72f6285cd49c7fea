"""Unit quaternions ``(w, x, y, z)``; the product composes as rotation matrices do.

J. Sola, "Quaternion kinematics for the error-state Kalman filter" (2017), Hamilton's convention.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from arael.geometry.arrays import Array, as_array, as_numbers
from arael.geometry.rotations import euler_angles, rotation_matrix


def quat_product(p: ArrayLike, q: ArrayLike) -> Array:
    """Hamilton product p q (..., 4): rotating by it is rotating by q, then by p."""
    a, b = as_array(p, (4,), "p"), as_array(q, (4,), "q")
    w = a[..., :1] * b[..., :1] - np.sum(a[..., 1:] * b[..., 1:], axis=-1, keepdims=True)
    v = a[..., :1] * b[..., 1:] + b[..., :1] * a[..., 1:] + np.cross(a[..., 1:], b[..., 1:])
    return np.concatenate([w, v], axis=-1)


def quat_conjugate(q: ArrayLike) -> Array:
    """Conjugates (..., 4): the inverse rotations."""
    return as_array(q, (4,), "q") * (1.0, -1.0, -1.0, -1.0)


def quat_rotate(q: ArrayLike, v: ArrayLike) -> Array:
    """Vectors `v` (..., 3) rotated by `q` (..., 4): ``v + 2 w (u x v) + 2 u x (u x v)``."""
    a, b = as_array(q, (4,), "q"), as_array(v, (3,), "v")
    u = a[..., 1:]
    t = 2 * np.cross(u, b)
    found: Array = b + a[..., :1] * t + np.cross(u, t)
    return found


def quat_exp(v: ArrayLike) -> Array:
    """Quaternions (..., 4) of rotation vectors `v` (..., 3) [rad]: ``(cos a/2, sin a/2 v/a)``."""
    vectors = as_array(v, (3,), "v")
    half = 0.5 * np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.concatenate([np.cos(half), 0.5 * np.sinc(half / np.pi) * vectors], axis=-1)


def quat_log(q: ArrayLike) -> Array:
    """Rotation vectors (..., 3) [rad], no longer than pi, of unit quaternions `q` (..., 4).

    Inverse of `quat_exp`; q and -q are the same rotation and have the same logarithm.
    """
    a = as_array(q, (4,), "q")
    a = np.where(a[..., :1] < 0, -a, a)
    u = a[..., 1:]
    sine = np.linalg.norm(u, axis=-1, keepdims=True)
    angle = 2 * np.arctan2(sine, a[..., :1])
    # angle / sine tends to 2 / w.
    tiny = sine < 1e-12
    factor = np.where(tiny, 2.0, angle / np.where(tiny, 1.0, sine))
    found: Array = factor * u
    return found


def quat_slerp(p: ArrayLike, q: ArrayLike, t: ArrayLike) -> Array:
    """Rotations (..., 4) a fraction `t` (...) of the way from `p` to `q`, along the shorter arc.

    Constant angular velocity: ``p exp(t log(p* q))``. `t` outside 0 to 1 extrapolates.
    """
    a, b = as_array(p, (4,), "p"), as_array(q, (4,), "q")
    step = quat_log(quat_product(quat_conjugate(a), b))
    share = as_numbers(t, "t")[..., None]
    return quat_product(a, quat_exp(share * step))


def quat_to_matrix(q: ArrayLike) -> Array:
    """Rotation matrices (..., 3, 3) of unit quaternions `q` (..., 4)."""
    a = as_array(q, (4,), "q")
    w, x, y, z = np.moveaxis(a, -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def quat_from_matrix(rotation: ArrayLike) -> Array:
    """Unit quaternions (..., 4), w >= 0, of rotation matrices (..., 3, 3).

    A matrix that is nearly a rotation is projected to the nearest one, as in SciPy.
    """
    # imported here: start-up time
    from scipy.spatial.transform import Rotation

    r = as_array(rotation, (3, 3), "rotation")
    if not r.size:
        return np.zeros((*r.shape[:-2], 4))
    found = np.roll(Rotation.from_matrix(r.reshape(-1, 3, 3)).as_quat(), 1, axis=-1)
    found = np.where(found[:, :1] < 0, -found, found)
    shaped: Array = found.reshape(*r.shape[:-2], 4)
    return shaped


def quat_from_euler(ea: ArrayLike) -> Array:
    """Unit quaternions (..., 4), w >= 0, of roll, pitch, yaw (..., 3) [rad]."""
    return quat_from_matrix(rotation_matrix(ea))


def quat_to_euler(q: ArrayLike) -> Array:
    """Roll, pitch, yaw (..., 3) [rad] of unit quaternions `q` (..., 4)."""
    return euler_angles(quat_to_matrix(q))
