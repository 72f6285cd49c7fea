"""Denavit-Hartenberg parameters of an arm, six of them held."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.optimize import OptimizeResult, least_squares
from scipy.spatial.transform import Rotation

from benchmarks.by_scipy import example

MODEL = "arm_calibration/arm_calibration.arael"
SIGMA = 1e-4


def link(theta: Any, d: float, a: float, alpha: float) -> Any:
    """Homogeneous matrices (n, 4, 4) of a joint at angles (n,)."""
    c, s, zero = np.cos(theta), np.sin(theta), np.zeros_like(theta)
    ca, sa = np.cos(alpha), np.sin(alpha)
    rows = [
        [c, -s * ca, s * sa, a * c],
        [s, c * ca, -c * sa, a * s],
        [zero, zero + sa, zero + ca, zero + d],
        [zero, zero, zero, zero + 1],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def residuals(x: Any, free: Any, links: Any, tool: Any, arm: Any) -> Any:
    """Residuals of the base (rotation vector, translation) and the free link parameters."""
    links = links.copy()
    links[free] = x[6:]
    found = np.append(tool, 1.0)[:, None]
    for k in reversed(range(7)):
        theta, d, a, alpha = links[k]
        found = link(arm.q[:, k] + theta, d, a, alpha) @ found
    there = Rotation.from_rotvec(x[:3]).apply(found[:, :3, 0]) + x[3:6]
    return ((there - arm.seen) / SIGMA).ravel()


def solve(arm: Any) -> OptimizeResult:
    """Solution of SciPy from the drawing."""
    script = example("arm_calibration")
    free = np.ones((7, 4), dtype=bool)
    for joint, name in script.HELD:
        free[joint, script.NAMES.index(name)] = False
    x = np.concatenate([[0, 0, 2.0, 2.0, -0.5, 0.0], script.DRAWING[free]])
    return least_squares(
        residuals, x, args=(free, script.DRAWING, script.TOOL, arm), x_scale="jac", xtol=1e-12
    )


def data(seed: int = 1) -> Any:
    """Positions in 60 postures."""
    return example("arm_calibration").simulate(seed=seed)


def by_arael(arm: Any) -> float:
    """Cost at the solution of arael."""
    return float(example("arm_calibration").held(arm).solve().end_cost)


def by_scipy(arm: Any) -> float:
    """Cost at the solution of SciPy."""
    return float(2 * solve(arm).cost)


PROGRAM = (link, residuals, solve)
