"""Minimisation of ``tr(Y Q Y')`` over matrices whose rotations are orthonormal columns, by rank.

``Y`` is (p, size), p at least d. The blocks of d columns that stand for rotations are orthonormal
(a product of Stiefel manifolds), positions are free. Riemannian trust region with truncated
conjugate gradients (P.-A. Absil, C. Baker and K. Gallivan, "Trust-region methods on Riemannian
manifolds", 2007), preconditioned with a factor of Q; the Hessian along V is ``2 V (Q - Lambda)``
projected, with the multipliers Lambda of Y.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_SMALL = 1e-11
"""Norm of the gradient in the metric of the preconditioner, relative to the cost, at the end."""
_ROUNDING = 1e-12
_MOST, _INNER = 100, 200


class Manifold:
    """The constraints of a chordal problem.

    Parameters
    ----------
    rotations : (m,) first columns of the rotations
    d : columns of a rotation
    """

    def __init__(self, rotations: Ints, d: int) -> None:
        self.columns = rotations[:, None] + np.arange(d)

    def multipliers(self, y: Floats, image: Floats) -> Floats:
        """(m, d, d) symmetric multipliers at y, with ``image = y Q``."""
        products = np.einsum("pmi,pmj->mij", y[:, self.columns], image[:, self.columns])
        found: Floats = (products + products.transpose(0, 2, 1)) / 2
        return found

    def tangent(self, y: Floats, v: Floats) -> Floats:
        """The part of v along the constraints, where the axes of the world stay."""
        blocks = y[:, self.columns]
        products = np.einsum("pmi,pmj->mij", blocks, v[:, self.columns])
        products = (products + products.transpose(0, 2, 1)) / 2
        found = v.copy()
        found[:, self.columns] -= np.einsum("pmi,mij->pmj", blocks, products)
        found[:, self.columns[0]] = 0
        return found

    def times_multipliers(self, v: Floats, multipliers: Floats) -> Floats:
        """``v Lambda``."""
        found = np.zeros_like(v)
        found[:, self.columns] = np.einsum("pmi,mij->pmj", v[:, self.columns], multipliers)
        return found

    def nearest(self, y: Floats) -> Floats:
        """The nearest point that obeys the constraints: polar factors of the blocks."""
        u, _, vt = np.linalg.svd(y[:, self.columns].transpose(1, 0, 2), full_matrices=False)
        found = y.copy()
        found[:, self.columns] = (u @ vt).transpose(1, 0, 2)
        return found


def minimise(
    manifold: Manifold, q: Any, y: Floats, precondition: Callable[[Floats], Floats]
) -> Floats:
    """A stationary point of second order near y.

    Parameters
    ----------
    q : sparse, symmetric
    precondition : product with an approximate inverse of q, of rows (p, size)
    """
    radius = np.sqrt(y.size)
    image = _times(q, y)
    cost = float(np.sum(image * y))
    floor = _SMALL**2 * max(cost, 1e-300)
    for _ in range(_MOST):
        multipliers = manifold.multipliers(y, image)
        gradient = manifold.tangent(y, image)
        ahead = manifold.tangent(y, precondition(gradient))
        if float(np.sum(gradient * ahead)) <= floor:
            break

        def along(v: Floats, y: Floats = y, multipliers: Floats = multipliers) -> Floats:
            return manifold.tangent(y, _times(q, v) - manifold.times_multipliers(v, multipliers))

        def conditioned(v: Floats, y: Floats = y) -> Floats:
            return manifold.tangent(y, precondition(v))

        step, predicted = _truncated(along, conditioned, gradient, radius)
        trial = manifold.nearest(y + step)
        trial_image = _times(q, trial)
        trial_cost = float(np.sum(trial_image * trial))
        ratio = (cost - trial_cost) / max(predicted, 1e-300)
        size = float(np.linalg.norm(step))
        if predicted <= _ROUNDING * cost:  # the cost is the same to rounding
            y = trial if trial_cost <= cost else y
            break
        if ratio > 0.1:
            y, image, cost = trial, trial_image, trial_cost
        radius = 0.25 * size if ratio < 0.25 else max(radius, 2 * size) if ratio > 0.75 else radius
        if radius < 1e-12:
            break
    return y


def _times(q: Any, y: Floats) -> Floats:
    return np.ascontiguousarray((q @ y.T).T)


def _truncated(
    product: Callable[[Floats], Floats],
    conditioned: Callable[[Floats], Floats],
    gradient: Floats,
    radius: float,
) -> tuple[Floats, float]:
    """Step of truncated conjugate gradients, and the decrease of the cost that it predicts."""
    step = np.zeros_like(gradient)
    residual = gradient
    ahead = conditioned(residual)
    direction = -ahead
    size = float(np.sum(residual * ahead))
    start, decrease = size, 0.0
    for _ in range(_INNER):
        image = product(direction)
        curvature = float(np.sum(direction * image))
        length = size / curvature if curvature > 0 else np.inf
        if curvature <= 0 or np.linalg.norm(step + length * direction) >= radius:
            a = float(np.sum(direction * direction))
            b = float(np.sum(step * direction))
            c = float(np.sum(step * step)) - radius**2
            length = (-b + np.sqrt(max(b * b - a * c, 0.0))) / a
            decrease += 2 * length * size - length**2 * curvature
            return step + length * direction, decrease
        step = step + length * direction
        decrease += length * size
        residual = residual + length * image
        ahead = conditioned(residual)
        before, size = size, float(np.sum(residual * ahead))
        if size <= min(0.01, np.sqrt(start)) * start * 0.01:
            break
        direction = -ahead + size / before * direction
    return step, decrease
