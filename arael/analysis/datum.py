"""Covariance where directions are free: inner constraints, and the change from datum to datum.

With free directions G (n, f) a covariance exists only with a datum ``E'dx = 0``, E (n, f), that
says which of the equivalent solutions is meant. Of G, the part G1 is in the null space of J'J;
along the others residuals change, but not the cost. With Z a basis of the complement of E, it is

    C = Z (Z'J'JZ)^-1 Z'

E = G are inner constraints: of all data this has the least trace, and it is the Moore-Penrose
inverse of J'J if G1 = G (P. Meissl, 1969; E. Grafarend and B. Schaffrin, "Equivalence of estimable
quantities and invariants in geodetic networks", ZfV 101 (1976)). From one datum to another, E2, it
is transformed by

    C2 = S C S',    S = I - G (E2'G)^-1 E2'

(W. Baarda, "S-transformations and criterion matrices", 1973).

Here C is that of a sparse system with f1 scalars held, which G1 could move, plus a matrix of low
rank: with the minimum over y, held there, and ``x = y + G1 c``, E'x = 0 leaves ``c = -R'y``, ``R' =
(E'G1)^+ E'``, and constraints ``F'y = 0``, F = E K, K the left null space of E'G1.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arael.analysis.freedom import FreeDirections

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_RANK = 1e-9
"""Smallest singular value of E'G, relative to the largest, of a datum that determines all."""


@dataclass(frozen=True)
class Datum:
    """What is added to the covariance of a system with some scalars held.

    Attributes
    ----------
    free : (n, f) orthonormal basis of the free directions, in the units of the parameters
    left, right : (n, r) factors of the matrix ``left @ right.T``
    """

    free: Floats
    left: Floats
    right: Floats

    @classmethod
    def inner(cls, base: Callable[[Floats], Floats], null: Floats, others: Floats) -> Datum:
        """Inner constraints, E = G.

        Parameters
        ----------
        base : product with the covariance of the system with held scalars
        null : (n, f1) orthonormal basis of free directions that change no residual
        others : (n, f - f1) orthonormal basis of the others, orthogonal to `null`
        """
        free = np.column_stack([null, others])
        # E'G1 has the unit matrix above zeros, so R = G1, K chooses the others, and F = others.
        along = base(others)
        root = np.linalg.cholesky(others.T @ along) if others.shape[1] else np.zeros((0, 0))
        q = np.linalg.solve(root, along.T).T if others.shape[1] else along
        w = base(null) - q @ (q.T @ null)
        left = np.column_stack([-q, -null, null @ (null.T @ w) - w])
        return cls(free, left, np.column_stack([q, w, null]))

    def transformed(self, base: Callable[[Floats], Floats], chosen: Ints) -> Datum | None:
        """In the datum of some scalars, E2 = G there and 0 elsewhere; None if it is none."""
        e = np.zeros_like(self.free)
        e[chosen] = self.free[chosen]
        values = np.linalg.svd(self.free[chosen], compute_uv=False)
        count = self.free.shape[1]
        if len(values) < count or values[-1] ** 2 < _RANK * values[0] ** 2:
            return None
        r = e @ np.linalg.inv(e.T @ self.free).T
        x = base(r) + self.left @ (self.right.T @ r)
        g = self.free
        return Datum(
            g,
            np.column_stack([self.left, -g, g @ (r.T @ x) - x]),
            np.column_stack([self.right, x, g]),
        )

    def block(self, a: Ints, b: Ints) -> Floats:
        """(len(a), len(b)) entries of what is added."""
        found: Floats = self.left[a] @ self.right[b].T
        return found


def bases_of(directions: FreeDirections) -> tuple[Floats, Floats]:
    """Orthonormal bases of the directions that change no residual, and of the others.

    The second is orthogonal to the first.
    """
    count = directions.parameters
    null = [one.vector for one in directions if not one.residuals_change]
    others = [one.vector for one in directions if one.residuals_change]
    first = np.linalg.qr(np.column_stack(null))[0] if null else np.zeros((count, 0))
    if not others:
        return first, np.zeros((count, 0))
    rest = np.column_stack([one / np.linalg.norm(one) for one in others])
    rest -= first @ (first.T @ rest)
    return first, np.linalg.qr(rest)[0]


def scalars_to_hold(null: Floats, scale: Floats) -> Ints:
    """Scalars without which nothing is left in the null space `null` (n, f): the best conditioned.

    Parameters
    ----------
    scale : (n,) units in which J'J has the diagonal 1
    """
    if not null.shape[1]:
        return np.zeros(0, dtype=np.int64)
    # imported here: start-up time
    from scipy.linalg import qr

    scaled = null / scale[:, None]
    order = qr((scaled / np.linalg.norm(scaled, axis=0)).T, pivoting=True, mode="economic")[2]
    return np.asarray(order[: null.shape[1]], dtype=np.int64)
