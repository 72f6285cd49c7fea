"""Directions in which the cost is flat to second order at a minimum, of small problems.

The Hessian of half the cost is ``H = J'J + S`` with ``S = sum_i r_i (d2 r_i)``, which Gauss-Newton
leaves out. A direction x with ``x'Hx = 0`` where ``x'J'Jx`` is not is free at the minimum, though
J'J calls it determined. Here H comes from central differences of the gradient, and the directions
are the eigenvectors with eigenvalue 0 of the pencil ``H x = mu J'J x``: 1 where S is negligible,
negative at a saddle.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arael.analysis.normal import NormalEquations
from arael.runtime.problem import Problem

Floats = NDArray[np.float64]

MOST_SCALARS = 120
"""Largest problem: two gradients a scalar, a few milliseconds."""
_STEP = 1e-3
"""Step of the differences, in the scaled unit that changes residuals by one sigma."""
_AT_MINIMUM = 1e-8
"""Predicted decrease of a full step, relative to the cost, up to which it is a minimum."""
_FLAT = 1e-4
"""Largest eigenvalue of a flat direction."""
_SURE = 1e-3
"""Largest asymmetry of the pencil, an estimate of its error, at which it decides."""


def flat_directions(equations: NormalEquations, null: Floats) -> Floats:
    """(n, k) directions beyond the null space of J'J, orthonormal in scaled units.

    None in a larger problem, away from a minimum, and where rounding does not let it be decided.

    Parameters
    ----------
    null : (n, f) free directions of J'J, orthonormal in scaled units
    """
    problem, n = equations.problem, len(equations.free)
    nothing = np.zeros((n, 0))
    if not 0 < n <= MOST_SCALARS or null.shape[1] == n or problem.layout.precision == "f32":
        return nothing
    if problem.evaluation.updating:
        return nothing
    scale = equations.scale[equations.free]
    held = np.linalg.qr(null, mode="complete")[0][:, null.shape[1] :]
    try:
        factor = np.linalg.cholesky(held.T @ equations.dense @ held)
    except np.linalg.LinAlgError:
        return nothing
    cost, half = problem.cost(), 0.5 * problem.gradient()
    step = np.linalg.solve(factor, held.T @ (_of(half, problem, equations) * scale))
    if step @ step > _AT_MINIMUM * cost:
        return nothing
    hessian = held.T @ (_hessian(equations, _STEP * scale) * scale[:, None] * scale) @ held
    pencil = np.linalg.solve(factor, np.linalg.solve(factor, hessian).T)
    if not np.isfinite(pencil).all() or np.abs(pencil - pencil.T).max() > _SURE:
        return nothing
    values, vectors = np.linalg.eigh((pencil + pencil.T) / 2)
    flat = np.linalg.solve(factor.T, vectors[:, np.abs(values) <= _FLAT])
    return held @ np.linalg.qr(flat)[0] if flat.shape[1] else nothing


def _of(values: Floats, problem: Problem, equations: NormalEquations) -> Floats:
    """Entries of a vector over the free scalars of a problem that are free in the equations too."""
    return values[np.isin(problem.free, equations.free)]


def _hessian(equations: NormalEquations, steps: Floats) -> Floats:
    """(n, n) derivatives of half the gradient, by central differences; the state is restored."""
    problem, n = equations.problem, len(equations.free)
    evaluation = problem.evaluation
    start = [
        np.array(state[: len(block.free), : entity.stored])
        for entity, block, state in zip(
            problem.layout.entities, problem.structure.system.blocks, problem.states, strict=True
        )
    ]
    found = np.zeros((n, n))
    try:
        for k, scalar in enumerate(equations.free):
            for sign in (1, -1):
                for number, values in enumerate(start):
                    evaluation.start_at(number, values)
                move = np.zeros(problem.size)
                move[scalar] = sign * steps[k]
                evaluation.moved_by(move)
                gradient = np.asarray(evaluation.linearised()[1], dtype=np.float64)
                found[:, k] += sign * gradient[equations.free] / (2 * steps[k])
    finally:
        for number, values in enumerate(start):
            evaluation.start_at(number, values)
    return found
