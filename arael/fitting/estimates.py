"""Covariance of the parameters of a fit, from the Jacobian itself."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arael.analysis.report import Statistics
from arael.fitting.curve import Curve

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Estimates:
    """Uncertainty of a fit.

    Attributes
    ----------
    covariance : (p, p); zero for fixed parameters and those on an active bound, NaN without degrees
        of freedom where the scatter is needed
    moves : (p,) parameters that have a covariance
    statistics : of the residuals
    """

    covariance: Array
    moves: NDArray[np.bool_]
    statistics: Statistics

    @property
    def sigma(self) -> Array:
        """(p,) standard errors."""
        found: Array = np.sqrt(np.diag(self.covariance))
        return found


def estimates(
    curve: Curve, x: Array, moves: NDArray[np.bool_], scatter: bool, robust: bool
) -> Estimates:
    """``s^2 (J'J)^-1`` at a solution, by a QR factorisation of J with its columns scaled to 1.

    The inverse of ``J'J = R'R`` is ``R^-1 R^-T``: errors grow with the condition of J, not its
    square.

    Parameters
    ----------
    moves : parameters that are free and not on a bound
    scatter : whether s^2 is the variance of the residuals, else 1
    robust : whether there is a loss

    Raises
    ------
    SolveError
        E1008: J has no full rank.
    """
    residuals, matrix = curve(x)
    cost = float(residuals @ residuals)
    count = int(np.count_nonzero(moves))
    statistics = Statistics(cost, len(residuals), count, scatter, robust)
    covariance = np.zeros((len(x), len(x)))
    if count:
        part = matrix[:, moves]
        length = np.sqrt((part**2).sum(axis=0))
        scaled = part / np.where(length > 0, length, 1.0)
        values = np.linalg.svd(scaled, compute_uv=False)
        if len(values) < count or values[-1] <= max(scaled.shape) * np.finfo(float).eps * values[0]:
            curve.model.covariance()  # reports the free directions
        inverse = np.linalg.pinv(np.linalg.qr(scaled)[1], rcond=1e-16) / length[:, None]
        covariance[np.ix_(moves, moves)] = inverse @ inverse.T * statistics.variance
    return Estimates(covariance, moves, statistics)
