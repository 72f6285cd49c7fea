"""Newton's method on rotations and positions of d dimensions, with a sparse factor a step.

A tangent vector at X is ``X_k [w_k]`` for the rotation k, with skew ``[w_k]``, and free for
positions. With the basis B of these, column after column of X, the Hessian of half the cost
``tr(X Q X')`` along it is ``B' (S x I) B`` with ``S = Q - Lambda``. Steps are damped where it is
not positive definite or the cost rises.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.certificates.blocks import BlockMatrix
from arael.certificates.manifold import Manifold

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_MOST = 50
_ENOUGH = 1e-10
"""Predicted decrease, relative to the cost, of the last step: convergence is quadratic, and a
certificate is to within 1e-6."""
_FIRST, _LARGEST = 1e-8, 1e8
"""First and largest damping, relative to the mean diagonal entry."""


def newton(
    manifold: Manifold,
    q: Any,
    multipliers: Callable[[Floats], tuple[Floats, Any]],
    x: Floats,
    blocks: Ints,
) -> Floats:
    """A minimum near x (d, size).

    Parameters
    ----------
    multipliers : Lambda at x, and ``S = q - Lambda``
    blocks : number of columns of each block, the axes of the world first
    """
    d = len(x)
    cost = _cost(q, x)
    damping = 0.0
    matrix: BlockMatrix | None = None
    for _ in range(_MOST):
        _, s = multipliers(x)
        basis, sizes = _basis(manifold, x, blocks)
        # B' (S x I) B by rows of X, without the larger product of Kronecker.
        parts = [basis[k::d] for k in range(d)]
        hessian = sum((part.T @ (s @ part) for part in parts[1:]), parts[0].T @ (s @ parts[0]))
        hessian = hessian.tocsr()
        gradient = basis.T @ np.ascontiguousarray(s @ x.T).ravel()
        if matrix is None:
            matrix = BlockMatrix(sizes, hessian)
        ones = np.full(len(gradient), matrix.mean)
        while True:
            solver = matrix.factorised(hessian, damping * ones)
            if solver is None:
                damping = max(_FIRST, 10 * damping)
                if damping > _LARGEST:
                    return x
                continue
            step = -np.asarray(solver.solved(gradient))
            predicted = -float(gradient @ step)
            trial = manifold.nearest(x + (basis @ step).reshape(-1, d).T)
            trial_cost = _cost(q, trial)
            if trial_cost <= cost or predicted <= 1e-13 * cost:
                break
            damping = max(_FIRST, 10 * damping)
            if damping > _LARGEST:
                return x
        x, cost = trial, trial_cost
        damping = 0.0 if damping <= _FIRST else damping / 10
        if predicted <= _ENOUGH * cost and damping <= _FIRST:
            return x
    return x


def _cost(q: Any, x: Floats) -> float:
    return float(np.sum((q @ x.T).T * x))


def _basis(manifold: Manifold, x: Floats, blocks: Ints) -> tuple[Any, Ints]:
    """B, with rows by columns of x, and the number of tangent scalars of each block."""
    # imported here: start-up time
    from scipy.sparse import coo_array

    d = len(x)
    turns = skew_basis(d)
    ends = np.cumsum(blocks)
    is_rotation = np.zeros(x.shape[1], dtype=bool)
    is_rotation[manifold.columns.ravel()] = True
    columns = manifold.columns[1:]  # the axes of the world stay
    scalars = np.where(is_rotation, 0, d)
    scalars[columns[:, 0]] = len(turns)
    scalars[:d] = 0
    start = np.cumsum(scalars) - scalars
    moved = np.einsum("pmi,aij->mapj", x[:, columns], turns)  # (rotations, turns, d, d)
    at = columns[:, None, None, :] * d + np.arange(d)[:, None]
    rows = [np.broadcast_to(at, moved.shape).ravel()]
    across = start[columns[:, 0]][:, None, None, None] + np.arange(len(turns))[:, None, None]
    found = [np.broadcast_to(across, moved.shape).ravel()]
    values = [moved.ravel()]
    free = np.flatnonzero(~is_rotation)
    rows.append((free[:, None] * d + np.arange(d)).ravel())
    found.append((start[free][:, None] + np.arange(d)).ravel())
    values.append(np.ones(len(free) * d))
    shape = (x.shape[1] * d, int(scalars.sum()))
    row, column, value = (np.concatenate(one) for one in (rows, found, values))
    basis = coo_array((value, (row, column)), shape=shape).tocsr()
    sizes = np.add.reduceat(scalars, ends - blocks)[1:]
    return basis, sizes


def skew_basis(d: int) -> Floats:
    """(k, d, d) a basis of skew matrices, of length one each."""
    found = []
    for i in range(d):
        for j in range(i):
            one = np.zeros((d, d))
            one[i, j], one[j, i] = 1, -1
            found.append(one / np.sqrt(2))
    return np.array(found)
