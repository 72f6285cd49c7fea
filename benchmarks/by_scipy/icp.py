"""Iterated closest points, point to plane."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.optimize import OptimizeResult, least_squares
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from benchmarks.by_scipy import example

MODEL = "icp/icp.arael"
SIGMA = 0.0055


def residuals(x: Any, p: Any, q: Any, n: Any) -> Any:
    """Distances of points from planes in sigmas, of a rotation vector and a translation."""
    return np.sum(n * (Rotation.from_rotvec(x[:3]).apply(p) + x[3:] - q), axis=1) / SIGMA


def geman_mcclure(z: Any) -> Any:
    """The loss with its two derivatives, as SciPy asks for it."""
    return np.array([z / (1 + z), 1 / (1 + z) ** 2, -2 / (1 + z) ** 3])


def solve(p: Any, q: Any, n: Any, reach: float, x: Any) -> OptimizeResult:
    """Solution of SciPy for the matches of a round."""
    return least_squares(
        residuals, x, args=(p, q, n), loss=geman_mcclure, f_scale=reach, x_scale="jac"
    )


def align(scans: Any, centres: Any, normals: Any) -> tuple[Any, float]:
    """Rotation vector and translation (6,), and the cost of the last round."""
    tree, x = cKDTree(scans.fixed), np.zeros(6)
    for _ in range(50):
        before = x
        distance, near = tree.query(Rotation.from_rotvec(x[:3]).apply(scans.moved) + x[3:])
        q, n = centres[near], normals[near] * (distance < 3 * np.median(distance))[:, None]
        reach = max(4.0, 3 * np.median(np.abs(residuals(x, scans.moved, q, n))))
        found = solve(scans.moved, q, n, reach, x)
        x = found.x
        if np.abs(x - before).max() < 1e-5:
            break
    return x, float(2 * found.cost)


def data(seed: int = 1) -> Any:
    """Two scans, and the planes of the first."""
    scans = example("icp").simulate(seed=seed)
    return scans, example("icp").planes(scans.fixed)


def by_arael(given: Any) -> float:
    """Cost of the last round by arael."""
    return float(example("icp").align(*given).model.cost())


def by_scipy(given: Any) -> float:
    """Cost of the last round by SciPy."""
    scans, planes = given
    return align(scans, *planes)[1]


PROGRAM = (residuals, geman_mcclure, solve, align)
