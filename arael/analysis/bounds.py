"""Parameters on an active bound, which are not free at the current values."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arael.runtime.levenberg.compiled import stored_places
from arael.runtime.problem import Problem

_ROUNDING = 1e-8
"""Relative length of a step that counts as zero."""


def standing_on_bounds(
    problem: Problem, gradient: NDArray[np.float64], diagonal: NDArray[np.float64]
) -> dict[int, str]:
    """Scalars on an active bound: the gradient points outwards or is zero.

    A scalar on a bound whose gradient points inwards is free.

    Parameters
    ----------
    problem : at its current values
    gradient, diagonal : (size,) J'r, and of J'J

    Returns
    -------
    Maps the number of the scalar in the system to its bound in words: ``its upper bound 10``.
    """
    system = problem.structure.system
    scalars = np.flatnonzero(np.isfinite(system.low) | np.isfinite(system.high))
    single = problem.layout.precision == "f32"
    found = {}
    for scalar, entity, at in zip(scalars, *stored_places(system, scalars), strict=True):
        x = float(problem.states[entity].ravel()[at])
        step = -gradient[scalar] / diagonal[scalar]
        slack = (1e-6 if single else 1e-14) * (1 + abs(x))  # the tolerance of the solver
        least = (1e-4 if single else _ROUNDING) * (1 + abs(x))
        low, high = float(system.low[scalar]), float(system.high[scalar])
        if x <= low + slack and step <= least:
            found[int(scalar)] = f"its lower bound {low:g}"
        elif x >= high - slack and step >= -least:
            found[int(scalar)] = f"its upper bound {high:g}"
    return found
