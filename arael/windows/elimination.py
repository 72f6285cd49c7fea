"""Elimination of leading columns of a linear least-squares problem by orthogonal transforms.

With the residuals ``r + A d + B x``, the minimum over d is the problem ``Q' (r + B x)`` with the
rows of an orthogonal Q' for which ``Q' A = 0`` (G. Golub and V. Pereyra, variable projection). It
is the square root of the Schur complement, without squared condition numbers. Directions of d that
no residual depends on are left out of the elimination, as the pseudo-inverse does.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Eliminated:
    """What remains of a problem.

    Attributes
    ----------
    jacobian : (k, n) rows of full rank
    residual : (k,)
    constant : part of the cost that no x changes
    undetermined : directions of the eliminated columns that no residual determines
    """

    jacobian: Floats
    residual: Floats
    constant: float
    undetermined: int


def eliminate(jacobian: Floats, residual: Floats, leading: int, tolerance: float) -> Eliminated:
    """Minimise over the first `leading` columns.

    Parameters
    ----------
    jacobian : (m, leading + n)
    residual : (m,)
    tolerance : relative to columns of length 1, below which a direction counts as undetermined
    """
    leaving = jacobian[:, :leading] / _lengths(jacobian[:, :leading])
    whole = np.column_stack([leaving, jacobian[:, leading:], residual])
    triangle = np.asarray(np.linalg.qr(whole, mode="r"))
    top, below = triangle[:leading], triangle[leading:, leading:]
    rank = 0
    if leading and len(top):
        own, _, turned = _pivoted(top[:, :leading], top[:, leading:])
        rank = _rank(own, tolerance)
        below = np.vstack([turned[rank:], below])
    lengths = _lengths(below[:, :-1])
    if not len(below) or below.shape[1] == 1:
        constant = float(np.square(below[:, -1]).sum())
        return Eliminated(np.zeros((0, below.shape[1] - 1)), np.zeros(0), constant, leading - rank)
    upper, order, turned = _pivoted(below[:, :-1] / lengths, below[:, -1:])
    kept = _rank(upper, tolerance)
    found = np.zeros((kept, below.shape[1] - 1))
    found[:, order] = upper[:kept]
    constant = float(np.square(turned[kept:]).sum())
    return Eliminated(found * lengths, turned[:kept, 0], constant, leading - rank)


def _pivoted(a: Floats, right: Floats) -> tuple[Floats, NDArray[np.intp], Floats]:
    """R and the order of columns of a QR decomposition with pivoting, and ``Q' right``."""
    # imported here: start-up time
    from scipy.linalg.lapack import dgeqp3, dormqr

    factor, order, tau, _, _ = dgeqp3(a)
    turned, _, _ = dormqr("L", "T", factor[:, : len(tau)], tau, right, 64 * right.shape[1] + 64)
    return np.triu(factor), order - 1, turned


def _lengths(columns: Floats) -> Floats:
    """(n,) Euclidean norms, 1 for columns of zeros."""
    found: Floats = np.linalg.norm(columns, axis=0)
    found[found == 0] = 1.0
    return found


def _rank(triangle: Floats, tolerance: float) -> int:
    """Rank of a triangular factor with pivoting, whose diagonal falls."""
    return int((np.abs(np.diagonal(triangle)) > tolerance).sum())
