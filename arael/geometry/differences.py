"""Differences of parameters as tangent vectors (boxminus): the inverse of the retraction."""

from __future__ import annotations

import numpy as np

from arael.geometry.arrays import Array
from arael.geometry.charts import rotation_step_matrix, tangent_basis
from arael.geometry.quaternions import (
    quat_conjugate,
    quat_log,
    quat_product,
    quat_rotate,
    quat_to_euler,
)
from arael.geometry.rotations import wrap_angle

CURVED = frozenset({"rotation", "quaternion", "direction", "transform", "similarity"})
"""Kinds of parameters whose retraction is not an addition."""


def difference(kind: str, base: Array, stored: Array) -> Array:
    """(n, k) tangent vectors d with ``base [+] d = stored``.

    Parameters
    ----------
    kind : as of `arael.geometry.charts.chart_derivative`
    base, stored : (n, s) values; quaternions and directions of length 1

    Notes
    -----
    The shortest rotation is taken, so that a quaternion and its negative give the same. The
    derivative by a step e at `stored` is the inverse of `chart_derivative` at d.
    """
    if kind == "angle":
        return wrap_angle(stored - base)
    if kind == "quaternion":
        return quat_log(quat_product(quat_conjugate(base), stored))
    if kind == "rotation":
        return quat_to_euler(quat_product(quat_conjugate(base), stored))
    if kind == "direction":
        return _along_sphere(base, stored)
    if kind in ("transform", "similarity"):
        return _twist(base, stored)
    return stored - base


def _twist(base: Array, stored: Array) -> Array:
    """(rho, phi) of ``T0^-1 T = exp(rho, phi)``, and the logarithm of the ratio of scales."""
    inverse = quat_conjugate(base[:, 3:7])
    phi = quat_log(quat_product(inverse, stored[:, 3:7]))
    moved = quat_rotate(inverse, stored[:, :3] - base[:, :3])
    if base.shape[1] == 8:
        moved = moved / base[:, 7:]
    rho = np.linalg.solve(rotation_step_matrix(phi), moved[:, :, None])[:, :, 0]
    parts = [rho, phi]
    if base.shape[1] == 8:
        parts.append(np.log(stored[:, 7:] / base[:, 7:]))
    return np.concatenate(parts, axis=1)


def _along_sphere(base: Array, stored: Array) -> Array:
    """Vector in the tangent plane at `base`, of the length of the arc to `stored`."""
    across = np.einsum("nij,ni->nj", tangent_basis(base), stored)
    sin = np.linalg.norm(across, axis=1)
    arc = np.arctan2(sin, np.einsum("ni,ni->n", base, stored))
    near = sin < 1e-8
    found: Array = across * np.where(near, 1.0, arc / np.where(near, 1.0, sin))[:, None]
    return found
