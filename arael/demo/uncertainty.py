"""Covariances of landmarks relative to their closest poses.

The marginal covariance of a landmark includes the uncertainty of the position and orientation of
the whole map. Relative to a pose this part cancels:

    C_rel = C_ll - C_lp - C_pl + C_pp,    C = 2 H^-1

with l the landmark's position and p the pose's; H = 2 J'J is the Gauss-Newton Hessian of the cost
(sum of squares, no 1/2).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

Array = NDArray[np.float64]
Index = NDArray[np.int64]


def relative_covariances(hessian: Array, landmarks: Index, poses: Index) -> Array:
    """Covariances (m, 3, 3) of landmarks relative to poses.

    Parameters
    ----------
    hessian : (n, n) Gauss-Newton Hessian of the cost
    landmarks, poses : (m,) first of the three consecutive parameters of each position

    Raises
    ------
    numpy.linalg.LinAlgError
        The Hessian is not positive definite.
    """
    count = len(landmarks)
    across = np.arange(3)
    columns = 3 * np.arange(count)[:, None] + across
    # Columns of the selection matrix of the differences l - p.
    difference = np.zeros((len(hessian), 3 * count))
    difference[landmarks[:, None] + across, columns] = 1.0
    difference[poses[:, None] + across, columns] -= 1.0
    solved = cho_solve(cho_factor(hessian, lower=True), difference)
    at_landmarks = solved[(landmarks[:, None] + across)[:, :, None], columns[:, None, :]]
    at_poses = solved[(poses[:, None] + across)[:, :, None], columns[:, None, :]]
    result: Array = 2.0 * (at_landmarks - at_poses)
    return result


def ellipsoid_axes(covariances: Array) -> Array:
    """Semi-axes (m, 3) of the one-sigma ellipsoids of `covariances` (m, 3, 3), descending."""
    values = np.linalg.eigvalsh(covariances)[:, ::-1]
    axes: Array = np.sqrt(np.maximum(values, 0.0))
    return axes
