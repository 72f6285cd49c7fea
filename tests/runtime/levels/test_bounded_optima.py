"""Optima of soft rows between bounds: multipliers at the end, signs included, and SLSQP."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize, nnls

from arael.runtime.levels.compiled import Levels, PythonRows

Array = NDArray[np.float64]
LENGTHS = np.array([30.0, 20.0, 15.0])
PATTERN = [[0, 1], [0, 1, 2, 3], [2, 3, 4, 5]]


def links(x: Array) -> Array:
    """Lengths of an arm of three links from the origin, less what they are to be."""
    return np.hypot(*np.diff(np.vstack([[0, 0], x.reshape(-1, 2)]), axis=0).T) - LENGTHS


def links_jacobian(x: Array) -> Array:
    joints = np.vstack([[0, 0], x.reshape(-1, 2)])
    rows = np.zeros((3, 6))
    for i, way in enumerate(np.diff(joints, axis=0)):
        rows[i, 2 * i : 2 * i + 2] = way / np.hypot(*way)
        if i:
            rows[i, 2 * i - 2 : 2 * i] = -way / np.hypot(*way)
    return rows


def multiplier_residual(x: Array, gradient: Array, low: Array, high: Array) -> float:
    """Part of a gradient that equations, and bounds with the right signs, do not balance."""
    normals = links_jacobian(x).T
    sides = np.eye(6)[:, x - low < 1e-7]
    upper = -np.eye(6)[:, high - x < 1e-7]
    left = nnls(np.hstack([normals, -normals, sides, upper]), gradient)[1]
    return float(left / max(np.linalg.norm(gradient), 1e-9))


def arm(seed: int) -> tuple[Array, Array, Array, np.random.Generator]:
    """A start that holds, and bounds around it."""
    rng = np.random.default_rng(seed)
    angles = rng.uniform(-np.pi, np.pi, 3)
    x = np.cumsum((LENGTHS * [np.cos(angles), np.sin(angles)]).T, axis=0).ravel()
    low = np.where(rng.random(6) < 0.6, x - rng.uniform(0, 15, 6), -np.inf)
    high = np.where(rng.random(6) < 0.6, x + rng.uniform(0, 15, 6), np.inf)
    return x, low, high, rng


def test_what_converged_between_bounds_is_an_optimum() -> None:
    converged = 0
    for seed in range(60):
        x, low, high, rng = arm(seed)
        target, weight = rng.uniform(-60, 60, 6), rng.uniform(0, 1, 6) * (rng.random(6) < 0.7)
        soft = PythonRows(
            lambda v, t=target, w=weight: w * (v - t), n=6, m=6, pattern=[[i] for i in range(6)]
        )
        rows = PythonRows(links, n=6, m=3, pattern=PATTERN)
        outcome = Levels(rows, soft).minimise(x, low=low, high=high, limit=300)
        assert outcome.solved
        assert np.abs(links(x)).max() < 1e-9
        assert ((low <= x) & (x <= high)).all()
        if not outcome.converged:
            continue
        converged += 1
        gradient = 2 * weight**2 * (x - target)
        assert multiplier_residual(x, gradient, low, high) <= 2e-6, seed
        better = minimize(
            lambda v, t=target, w=weight: np.sum((w * (v - t)) ** 2),
            x,
            jac=lambda v, t=target, w=weight: 2 * w**2 * (v - t),
            bounds=list(zip(low, high, strict=True)),
            constraints={"type": "eq", "fun": links, "jac": links_jacobian},
            method="SLSQP",
            options={"ftol": 1e-12, "maxiter": 500},
        )
        if better.success:
            assert outcome.soft**2 <= better.fun * (1 + 1e-6) + 1e-9, seed
    assert converged >= 58


def test_closest_state_between_bounds_is_that_of_slsqp() -> None:
    closest = 0
    for seed in range(40):
        x, low, high, rng = arm(seed)
        home, target = x + rng.uniform(-30, 30, 6), x[4]  # the soft row can be zero
        soft = PythonRows(lambda v, t=target: v[4:5] - t, n=6, m=1, pattern=[[4]])
        rows = PythonRows(links, n=6, m=3, pattern=PATTERN)
        outcome = Levels(rows, soft).minimise(x, low=low, high=high, home=home)
        assert outcome.solved
        if not outcome.converged:
            continue
        closest += 1
        better = minimize(
            lambda v, h=home: np.sum((v - h) ** 2),
            x,
            jac=lambda v, h=home: 2 * (v - h),
            bounds=list(zip(low, high, strict=True)),
            constraints={
                "type": "eq",
                "fun": lambda v, t=target: np.append(links(v), v[4] - t),
                "jac": lambda v: np.vstack([links_jacobian(v), np.eye(6)[4]]),
            },
            method="SLSQP",
            options={"ftol": 1e-12, "maxiter": 500},
        )
        if better.success:
            assert np.sum((x - home) ** 2) <= better.fun * (1 + 1e-5) + 1e-9, seed
    assert closest >= 36
