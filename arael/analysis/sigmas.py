"""Standard deviations of determined parameters, also for singular systems."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from arael.analysis.freedom import FreeDirections
from arael.analysis.normal import NormalEquations
from arael.runtime.failures import SolveError
from arael.runtime.problem import Problem

MOST_SCALARS = 5000
"""Largest system that is factorised, so that this takes no longer than the solve."""
_MOST_DENSE = 400
"""Largest system that is decomposed into eigenvectors."""
_APART = 1e-7
"""Largest relative entry in free directions of a determined scalar."""


@dataclass(frozen=True)
class Sigmas:
    """Standard deviations by the name of a scalar.

    Attributes
    ----------
    values : of the scalars that the residuals determine
    on_bound : scalars on an active bound, with the bound in words
    notes : reasons for missing values, in words
    """

    values: dict[str, float] = field(default_factory=dict)
    on_bound: dict[str, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def sigmas(problem: Problem) -> Sigmas:
    """Standard deviations at the current values; never raises for a singular system.

    In a small singular system, the scalars without entries in the free directions have standard
    deviations (from the pseudo-inverse of J'J), the others have none.
    """
    if problem.size > MOST_SCALARS:
        why = f"standard deviations are omitted: more than {MOST_SCALARS} parameters"
        return Sigmas(notes=(why, "`--covariance FILE` writes them"))
    try:
        equations = NormalEquations(problem, hold_bounds=True)
        if len(equations.free) > _MOST_DENSE:
            from arael.analysis.covariance import Covariance

            found = Covariance(problem)
            values = dict(zip(found.names, found.sigma().tolist(), strict=True))
            return Sigmas(values, found.on_bound)
    except SolveError as error:
        first = error.diagnostics[0]
        return Sigmas(notes=(first.message, *first.notes))
    eigenvalues, vectors = np.linalg.eigh(equations.dense)
    loose = eigenvalues <= equations.tolerance
    determined = np.linalg.norm(vectors[:, loose], axis=1) < _APART
    variance = (vectors[:, ~loose] ** 2) @ (1 / eigenvalues[~loose])
    all_sigmas = np.sqrt(variance) * equations.scale[equations.free]
    named = zip(equations.names, all_sigmas.tolist(), determined, strict=True)
    values = {name: sigma for name, sigma, known in named if known}
    if not loose.any():
        return Sigmas(values, equations.on_bound)
    found_free = FreeDirections(equations, vectors[:, loose]).as_error()
    notes = (found_free.message, *found_free.notes)
    return Sigmas(values, equations.on_bound, notes)
