"""A X = Y B on poses of a robot and of its camera."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.optimize import OptimizeResult, least_squares
from scipy.spatial.transform import Rotation

from benchmarks.by_scipy import example

MODEL = "hand_eye/robot_world.arael"


def log(turn: Any, t: Any) -> Any:
    """Logarithms (n, 6) of rigid transforms: translation, rotation."""
    phi = turn.as_rotvec()
    half = np.maximum(np.linalg.norm(phi, axis=1)[:, None] / 2, 1e-9)
    once = np.cross(phi, t)
    rho = t - once / 2 + (1 - half / np.tan(half)) / (2 * half) ** 2 * np.cross(phi, once)
    return np.hstack([rho, phi])


def residuals(x: Any, poses: Any, sigma: Any) -> Any:
    """Residuals of the rotation vector and translation of X, then of Y."""
    x_turn, y_turn = Rotation.from_rotvec(x[:3]), Rotation.from_rotvec(x[6:9])
    a_turn, b_turn = (Rotation.from_matrix(p[:, :3, :3]) for p in (poses.a, poses.b))
    left = a_turn * x_turn
    left_t = a_turn.apply(x[3:6]) + poses.a[:, :3, 3]
    right_t = y_turn.apply(poses.b[:, :3, 3]) + x[9:]
    return (log(left.inv() * y_turn * b_turn, left.inv().apply(right_t - left_t)) / sigma).ravel()


def solve(poses: Any) -> OptimizeResult:
    """Solution of SciPy from two identities."""
    sigma = example("hand_eye").SIGMA
    return least_squares(residuals, np.zeros(12), args=(poses, sigma), x_scale="jac")


def data(seed: int = 1) -> Any:
    """Poses of 30 shots."""
    return example("hand_eye").simulate(seed=seed)


def by_arael(poses: Any) -> float:
    """Cost at the solution of arael."""
    return float(example("hand_eye").robot_world(poses).solve().end_cost)


def by_scipy(poses: Any) -> float:
    """Cost at the solution of SciPy."""
    return float(2 * solve(poses).cost)


PROGRAM = (log, residuals, solve)
