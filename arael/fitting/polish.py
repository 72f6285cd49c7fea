"""The last digits of a fit, by Gauss-Newton steps on a QR factorisation of the Jacobian.

The normal equations of the solver square its condition. With the Jacobian itself the step is exact
to its condition times the machine precision, which for the ill-conditioned problems of NIST's
collection is several digits more (A. Bjorck, "Numerical methods for least squares problems", 1996,
section 2.4).
"""

from __future__ import annotations

from math import sqrt

import numpy as np
from numpy.typing import NDArray

from arael.fitting.curve import Curve

Array = NDArray[np.float64]

_STEPS = 60


def polished(curve: Curve, x: Array, moves: NDArray[np.bool_]) -> tuple[Array, float]:
    """Improve a solution until the predicted decrease of the cost does not fall any more.

    Parameters
    ----------
    x : (p,) the end of a solve
    moves : (p,) free parameters that are not on an active bound

    Returns
    -------
    x : (p,) the parameters of the least predicted decrease; those of the solve where no step helped
    promise : that decrease, as a fraction of the cost
    """
    best, promise = x, np.inf
    least = curve.cost(x)
    for _ in range(_STEPS):
        residuals, matrix = curve(x)
        cost = float(residuals @ residuals)
        # Costs near the least differ by their rounding alone.
        if not np.isfinite(matrix).all() or not cost <= least + _noise(cost, matrix, x):
            break
        least = min(least, cost)
        part = matrix[:, moves]
        length = np.sqrt((part**2).sum(axis=0))
        if not length.all():
            break
        q, r = np.linalg.qr(part / length)
        along = q.T @ -residuals
        found = float(along @ along) / cost if cost > 0 else 0.0
        if found >= promise:
            break
        best, promise = x, found
        if promise == 0 or np.abs(np.diag(r)).min() < len(residuals) * np.finfo(float).eps:
            break
        x = best.copy()
        x[moves] += np.linalg.solve(r, along) / length
        x = np.clip(x, curve.low, curve.high)
    return best, promise


def _noise(cost: float, matrix: Array, x: Array) -> float:
    """Rounding noise of a cost, as the solver estimates it for `Result.noise_floor`.

    It is that of the terms of the residuals, which are much larger than the residuals where a curve
    fits well: 1e-11 of the cost and more for data of six digits.
    """
    epsilon = float(np.finfo(float).eps)
    terms = (epsilon * float(np.linalg.norm(matrix * x))) ** 2
    return 4 * epsilon * cost + 2 * sqrt(cost * terms) + terms
