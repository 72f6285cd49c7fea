"""Problems of few rotations with data on both sides of them, as of hand-eye calibration.

``A X = X B`` has no residual ``X E`` of columns alone. In ``z = [1, vec(R_1), ...]`` it is linear,
as ``vec(A R B) = (B' x A) vec(R)``; positions, which nothing constrains, are the best for z. The
cost is ``z' Q z`` with a small dense Q.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arael.certificates.framed import FramedProblem
from arael.certificates.newton import skew_basis
from arael.certificates.quadratic import Frames, Residual, placed
from arael.certificates.relaxation import Bound, dual_bound

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

MOST_ROTATIONS, MOST_POSITIONS = 8, 100
"""Sizes for which the bound takes half a second: its work grows with the fifth power of the
number of rotations."""
_ROUNDING = 1e-8
"""Cost, relative to the largest entry of Q, of which rounding is the millionth part."""
_ENOUGH = 1e-13
"""Predicted decrease, relative to the scale of the cost, of the last step of Newton's method."""
_MOST = 100
_FIRST, _LARGEST = 1e-8, 1e8
"""First and largest damping, relative to the largest entry of Q."""


@dataclass(frozen=True, eq=False)
class TwoSidedProblem(FramedProblem):
    """Costs of a few rotations and positions as a quadratic form of all their entries.

    Attributes
    ----------
    whole : (n + d k, n + d k) of ``[z, t_1, ..., t_k]``
    q : (n, n) of z, positions at their best
    best : (d k, n) these positions are ``best @ z``
    """

    whole: Floats
    q: Floats
    best: Floats

    def scale(self, cost: float) -> float:
        """What a gap of a minimum of this cost is relative to."""
        return max(super().scale(cost), _ROUNDING * float(np.abs(self.q).max()))

    def cost(self, x: Floats) -> float:
        """The cost of X (d, size)."""
        w = np.concatenate([self._z(x), x[:, _positions(self.frames)].T.ravel()])
        return max(float(w @ self.whole @ w), 0.0)

    def minimised(self, x: Floats) -> Floats:
        """A minimum near X, by Newton's method on the rotations."""
        z, damping = self._z(x), 0.0
        cost = float(z @ self.q @ z)
        largest = float(np.abs(self.q).max())
        for _ in range(_MOST):
            basis, gradient, hessian = self._derivatives(z)
            values, vectors = np.linalg.eigh(hessian)
            ahead = vectors.T @ gradient
            step = -ahead / np.maximum(np.abs(values) + damping, 1e-12 * largest)
            trial = self._nearest(z + basis @ (vectors @ step))
            trial_cost = float(trial @ self.q @ trial)
            last = -float(ahead @ step) <= _ENOUGH * self.scale(cost)
            if trial_cost <= cost:
                z, cost, damping = trial, trial_cost, damping / 10
            else:
                damping = max(10 * damping, _FIRST * largest)
            if last or damping > _LARGEST * largest:
                break
        return self._x(z)

    def bound(self, x: Floats, tolerance: float) -> Bound:
        """The bound of the dual for a minimum X."""
        # imported here: start-up time
        from threadpoolctl import threadpool_limits  # type: ignore[import-untyped, unused-ignore]

        m, d = len(self.frames.rotations) - 1, self.frames.d
        # Many small products: threads of BLAS make each slower, ten times on a busy machine.
        with threadpool_limits(limits=1, user_api="blas"):
            return dual_bound(self.q, m, d, self._z(x), tolerance)

    def rounded(self, z: Floats) -> Floats:
        """X with the rotations that are nearest to z (n,), and the best positions for them."""
        return self._x(self._nearest(z))

    def _z(self, x: Floats) -> Floats:
        at = self.frames.rotations[1:, None] + np.arange(self.frames.d)
        return np.concatenate([[1.0], x[:, at.ravel()].T.ravel()])

    def _x(self, z: Floats) -> Floats:
        frames = self.frames
        x = np.zeros((frames.d, frames.size))
        x[:, : frames.d] = np.eye(frames.d)
        at = frames.rotations[1:, None] + np.arange(frames.d)
        x[:, at.ravel()] = z[1:].reshape(-1, frames.d).T
        x[:, _positions(frames)] = (self.best @ z).reshape(-1, frames.d).T
        return x

    def _rotations(self, z: Floats) -> Floats:
        """(m, d, d) the matrices of z."""
        d = self.frames.d
        return z[1:].reshape(-1, d, d).transpose(0, 2, 1)

    def _nearest(self, z: Floats) -> Floats:
        """The nearest rotations to the matrices of z."""
        u, _, vt = np.linalg.svd(self._rotations(z))
        u[:, :, -1] *= np.linalg.det(u @ vt)[:, None]
        return np.concatenate([[1.0], (u @ vt).transpose(0, 2, 1).ravel()])

    def _derivatives(self, z: Floats) -> tuple[Floats, Floats, Floats]:
        """Basis of the tangent ``R [w]``, and gradient and Hessian of half the cost along it."""
        turned, turns = self._rotations(z), skew_basis(self.frames.d)
        m, count = len(turned), len(turns)
        moved = np.einsum("mij,ajk->maki", turned, turns)
        basis = np.zeros((len(z), m * count))
        for k, one in enumerate(moved.reshape(m, count, turned.shape[1] ** 2)):
            first = 1 + k * one.shape[1]
            basis[first : first + one.shape[1], k * count : (k + 1) * count] = one.T
        image = self.q @ z
        hessian = basis.T @ self.q @ basis
        # Rotations are R (I + [w] + [w]^2 / 2 ...).
        products = np.einsum("aij,bjk->abik", turns, turns)
        products = (products + products.transpose(1, 0, 2, 3)) / 2
        for k, (rotation, force) in enumerate(zip(turned, self._rotations(image), strict=True)):
            at = slice(k * count, (k + 1) * count)
            hessian[at, at] += np.einsum("ij,abij->ab", rotation.T @ force, products)
        return basis, basis.T @ image, hessian


def fits(frames: Frames) -> bool:
    """Whether there are few enough unknowns for dense matrices."""
    rotations = len(frames.rotations) - 1
    positions = len(_positions(frames))
    return rotations <= MOST_ROTATIONS and positions <= MOST_POSITIONS


def two_sided_matrices(
    frames: Frames, residuals: Sequence[Residual]
) -> tuple[Floats, Floats, Floats]:
    """`whole`, `q` and `best` of a `TwoSidedProblem`."""
    d, m = frames.d, len(frames.rotations) - 1
    entries = _matrix_of(frames, residuals)
    at = (frames.rotations[1:, None] + np.arange(d)).ravel()
    order = np.concatenate([at, _positions(frames)])
    scalars = (order[:, None] * d + np.arange(d)).ravel()
    axes = np.eye(d).ravel()  # the axes of the world, times the first entry of z
    whole = np.empty((1 + len(scalars), 1 + len(scalars)))
    whole[0, 0] = axes @ entries[: d * d, : d * d] @ axes
    whole[0, 1:] = whole[1:, 0] = (axes @ entries[: d * d])[scalars]
    whole[1:, 1:] = entries[np.ix_(scalars, scalars)]
    n = 1 + m * d * d
    if n == len(whole):
        return whole, whole, np.zeros((0, n))
    best = -np.linalg.pinv(whole[n:, n:], rcond=1e-12, hermitian=True) @ whole[n:, :n]
    q = whole[:n, :n] + whole[:n, n:] @ best
    return whole, (q + q.T) / 2, best


def _positions(frames: Frames) -> Ints:
    """Columns of X that are positions."""
    taken = frames.rotations[:, None] + np.arange(frames.d)
    return np.setdiff1d(np.arange(frames.size), taken)


def _matrix_of(frames: Frames, residuals: Sequence[Residual]) -> Floats:
    """(d size, d size) of the cost as a quadratic form of the entries of X, column by column."""
    # imported here: start-up time
    from scipy.sparse import coo_array

    d = frames.d
    found = np.zeros((d * frames.size, d * frames.size))
    for residual in residuals:
        n, root = len(residual.weight), np.sqrt(residual.weight)
        rows, columns, values = [], [], []
        for piece in residual.pieces:
            left = np.broadcast_to(np.eye(d) if piece.left is None else piece.left, (n, d, d))
            for chosen, start, right in placed(frames, piece, residual.ways, n):
                one = np.ones((len(chosen), 1, 1)) if right is None else right
                one = one.reshape(len(chosen), one.shape[1], -1)
                # Entry (i, w) of left R right, by entry (e, c) of R.
                value = piece.sign * np.einsum("k,kie,kcw->kwice", root[chosen], left[chosen], one)
                k, w, i, c, e = np.indices(value.shape, sparse=True)
                rows.append(np.broadcast_to((chosen[k] * d + w) * d + i, value.shape).ravel())
                columns.append(np.broadcast_to((start[k] + c) * d + e, value.shape).ravel())
                values.append(value.ravel())
        entries = [np.concatenate(each) for each in (rows, columns, values)]
        shape = (n * d * d, d * frames.size)
        jacobian = coo_array((entries[2], (entries[0], entries[1])), shape=shape).tocsr()
        found += (jacobian.T @ jacobian).toarray()
    return found
