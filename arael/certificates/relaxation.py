"""The dual of a quadratic problem in a few rotations, a small dense semidefinite program.

With ``z = [1, vec(R_1), ..., vec(R_m)]`` the cost is ``z' Q z``, and every constraint of rotations
is ``z' A_k z = 0``: ``R'R = I``, ``R R' = I``, and that each column is the cross product of the two
others, all of them, redundant as they are (J. Briales and J. Gonzalez-Jimenez, "Convex global 3D
registration with Lagrangian duality", CVPR 2017). For all multipliers with

    S = Q - gamma e e' - sum_k lambda_k A_k >= 0,    e = [1, 0, ...]

gamma is a lower bound of all costs. The largest is approached along the central path of the
logarithmic barrier (L. Vandenberghe and S. Boyd, "Semidefinite programming", SIAM Review 1996), on
which ``mu S^-1`` is the relaxation's matrix in place of ``z z'``, and the gap is mu times the size.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_REDUCTION = 0.05
"""Factor of mu from one point of the path to the next."""
_CENTRED = 0.3
"""Newton decrement of a point that is near enough to the path."""
_INSIDE = 0.95
"""Largest part of the way to the boundary that a step takes."""
_ROUNDING = 1e-12
"""Gap, relative to the largest entry of Q, at which the path ends: S is nearly singular there."""
_STEPS = 40
"""Most Newton steps of one point of the path; from the point before it takes 3 to 8."""
_NOT_TIGHT = 1e-2
"""Gap of the path, relative to that of the candidate, at which the latter is certain."""


@dataclass(frozen=True)
class Bound:
    """What the dual says of a candidate.

    Attributes
    ----------
    value : lower bound of all costs
    eigenvalue : least of S with multipliers of the candidate; 0 if it is not negative
    relaxed : (n,) the first column of the relaxation's matrix: z, where it is tight
    """

    value: float
    eigenvalue: float
    relaxed: Floats


def constraints(m: int, d: int) -> Floats:
    """(k, n, n) symmetric, linearly independent A_k with ``z' A_k z = 0`` for m rotations."""
    n = 1 + m * d * d
    found = []

    def one(*products: tuple[float, int, int]) -> None:
        a = np.zeros((n, n))
        for factor, i, j in products:
            a[i, j] += factor / 2
            a[j, i] += factor / 2
        found.append(a)

    for k in range(m):
        r = 1 + k * d * d + np.arange(d * d).reshape(d, d).T  # r[i, j] of row i, column j
        pairs = list(combinations_with_replacement(range(d), 2))
        for side in (r, r.T):
            # The trace of R R' is that of R'R.
            for a, b in pairs if side is r else pairs[:-1]:
                products = [(1.0, side[i, a], side[i, b]) for i in range(d)]
                one(*products, (-float(a == b), 0, 0))
        if d == 2:
            one((1.0, 0, r[0, 0]), (-1.0, 0, r[1, 1]))
            one((1.0, 0, r[1, 0]), (1.0, 0, r[0, 1]))
            continue
        for c in range(3):
            a, b = (c + 1) % 3, (c + 2) % 3
            for i in range(3):
                p, q = (i + 1) % 3, (i + 2) % 3
                one((1.0, r[p, a], r[q, b]), (-1.0, r[q, a], r[p, b]), (-1.0, 0, r[i, c]))
    return np.array(found).reshape(-1, n, n)


def dual_bound(q: Floats, m: int, d: int, z: Floats, tolerance: float) -> Bound:
    """The bound of the dual, as far as it tells whether z, a minimum, is the lowest.

    Parameters
    ----------
    q : (n, n) positive semidefinite
    tolerance : gap at which the candidate is the global optimum
    """
    n = len(q)
    size = float(np.abs(q).max())
    if size == 0:
        return Bound(0.0, 0.0, z)
    a = np.concatenate([np.zeros((1, n, n)), constraints(m, d)])
    a[0, 0, 0] = 1
    normals = (a @ z).T
    squared = 1.0 + d * m  # |z|^2 of all rotations
    cost = float(z @ q @ z)
    # Strictly feasible: the traces of R'R add the identity to Q, and gamma pays for it.
    flat = a.reshape(len(a), -1)
    dual = np.linalg.lstsq(flat.T, -size * np.eye(n).ravel())[0]
    mu = size
    value, eigenvalue, relaxed = -np.inf, 0.0, z
    while True:
        try:
            dual, inverse = _centred(q, flat, dual, mu)
        except np.linalg.LinAlgError:  # S is singular to rounding
            break
        relaxed = inverse[:, 0] / inverse[0, 0]
        # The nearest multipliers with S z = 0: for them gamma is the cost of z.
        change = np.linalg.lstsq(normals, q @ z - normals @ dual, rcond=1e-10)[0]
        s = q - ((dual + change) @ flat).reshape(n, n)
        eigenvalue = min(float(np.linalg.eigvalsh(s)[0]), 0.0)
        value = max(value, float(dual[0]), float((dual + change)[0]) + squared * eigenvalue)
        gap = n * mu
        if cost - value <= tolerance or gap <= max(0.1 * tolerance, _ROUNDING * size):
            break
        if gap <= _NOT_TIGHT * (cost - float(dual[0])):
            break
        mu *= _REDUCTION
    return Bound(value, eigenvalue, relaxed)


def _centred(q: Floats, flat: Floats, dual: Floats, mu: float) -> tuple[Floats, Floats]:
    """The point of the central path for mu, by Newton's method, and the inverse of S there.

    Minimises ``-gamma / mu - log det S``; flat has a row for each matrix that dual multiplies.
    """
    n = len(q)
    for _ in range(_STEPS):
        s = q - (dual @ flat).reshape(n, n)
        half = np.linalg.inv(np.linalg.cholesky(s))
        # L^-1 A_k L^-T: their products are the Hessian, their traces the gradient.
        turned = (half @ flat.reshape(-1, n, n) @ half.T).reshape(len(flat), -1)
        gradient = turned[:, :: n + 1].sum(axis=1)
        gradient[0] -= 1 / mu
        step = -np.linalg.solve(turned @ turned.T, gradient)
        decrement = np.sqrt(max(-float(gradient @ step), 0.0))
        ahead = float(np.linalg.eigvalsh((step @ turned).reshape(n, n))[-1])
        dual = dual + min(1.0, _INSIDE / max(ahead, 1e-300)) * step
        if decrement <= _CENTRED:
            break
    half = np.linalg.inv(np.linalg.cholesky(q - (dual @ flat).reshape(n, n)))
    return dual, half.T @ half
