"""Covariance of the parameters of a fit, from the Jacobian itself."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from arael.analysis.report import Statistics
from arael.fitting.curve import Curve
from arael.fitting.flat import flat_directions
from arael.runtime.failures import SolveError

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
    flat : sentences on parameters that are not determined, and what is in their place
    """

    covariance: Array
    moves: NDArray[np.bool_]
    statistics: Statistics
    flat: tuple[str, ...] = ()

    @property
    def sigma(self) -> Array:
        """(p,) standard errors."""
        found: Array = np.sqrt(np.diag(self.covariance))
        return found


def estimates(
    curve: Curve, x: Array, moves: NDArray[np.bool_], size: Array, scatter: bool, robust: bool
) -> Estimates:
    """``s^2 (J'J)^-1`` at a solution, by a QR factorisation of J with its columns scaled to 1.

    The inverse of ``J'J = R'R`` is ``R^-1 R^-T``: errors grow with the condition of J, not its
    square.

    Parameters
    ----------
    moves : parameters that are free and not on a bound
    size : (p,) magnitudes that the data give the parameters
    scatter : whether s^2 is the variance of the residuals, else 1
    robust : whether there is a loss

    Raises
    ------
    SolveError
        E1008: J has no full rank; the sentences of `flat` are among its notes.
    """
    residuals, matrix = curve(x)
    cost = float(residuals @ residuals)
    count = int(np.count_nonzero(moves))
    statistics = Statistics(cost, len(residuals), count, scatter, robust)
    covariance = np.zeros((len(x), len(x)))
    flat: tuple[str, ...] = ()
    if count:
        part = matrix[:, moves]
        names = [name for name, one in zip(curve.names, moves, strict=True) if one]
        deviation = float(np.sqrt(statistics.variance))

        def cost_at(values: Array) -> float:
            moved = x.copy()
            moved[moves] = values
            return curve.cost(moved)

        flat = flat_directions(names, x[moves], cost_at, part, size[moves], deviation)
        length = np.sqrt((part**2).sum(axis=0))
        scaled = part / np.where(length > 0, length, 1.0)
        values = np.linalg.svd(scaled, compute_uv=False)
        if len(values) < count or values[-1] <= max(scaled.shape) * np.finfo(float).eps * values[0]:
            _singular(curve, flat)
        inverse = np.linalg.pinv(np.linalg.qr(scaled)[1], rcond=1e-16) / length[:, None]
        with np.errstate(over="ignore"):
            covariance[np.ix_(moves, moves)] = inverse @ inverse.T * statistics.variance
    return Estimates(covariance, moves, statistics, flat)


def _singular(curve: Curve, flat: tuple[str, ...]) -> None:
    """Raise E1008 with the free directions and what is determined."""
    try:
        curve.model.covariance()
    except SolveError as error:
        first, *others = error.diagnostics
        advice = "fix one of these parameters (`fixed=`, `--fix`), or write the formula without it"
        found = replace(first, notes=(*first.notes, *flat), help=(advice,))
        raise SolveError([found, *others], error.best) from None
