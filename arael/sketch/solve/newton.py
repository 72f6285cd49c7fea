"""Dense Newton steps of least norm; stands in for the solver by levels."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.sketch.solve.outcome import Status


def dense(rows: Any, x: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Residuals and the whole Jacobian."""
    r, entries = rows.jacobian(x)
    matrix = np.zeros((rows.m, rows.n))
    matrix[np.repeat(np.arange(rows.m), np.diff(rows.indptr)), rows.indices] = entries
    return r, matrix


def solve(
    rows: Any, guards: Any, x: NDArray[np.float64], tolerance: float, low: Any, high: Any
) -> tuple[Status, int]:
    """Solve in place."""
    mu = 0.0
    for step in range(100):
        r, matrix = dense(rows, x)
        worst = np.abs(r).max(initial=0.0)
        if worst <= tolerance:
            return "solved", step
        before = guards.evaluate(x)
        if mu:
            k = matrix @ matrix.T + mu * np.eye(len(r))
            d = -matrix.T @ np.linalg.solve(k, r)
        else:
            d = -np.linalg.lstsq(matrix, r, rcond=1e-9)[0]
        length = 1.0
        while length > 1e-6:
            moved = np.clip(x + length * d, low, high)
            g = guards.evaluate(moved)
            new = np.linalg.norm(rows.evaluate(moved))
            if not (np.any((before > 0) & (g <= 0)) or new >= np.linalg.norm(r)):
                break
            length /= 2
        else:
            mu = max(10 * mu, 1e-6 * np.sum(matrix**2))
            if mu > 1e6 * np.sum(matrix**2):
                return "stalled", step
            continue
        mu /= 10
        if mu < 1e-9 * np.sum(matrix**2):
            mu = 0.0
        x[:] = moved
    return "step_limit", 100
