"""One sparse linear least-squares solve over the poses of a graph."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from arael.runtime.assembly.pattern import BlockPattern

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]


class SingularError(Exception):
    """The measurements do not determine every pose."""


class Relaxation:
    """Normal equations with one block of `d` scalars per pose, for both stages of a relaxation.

    Fixed poses stay in the system as identities, so that ordering and symbolic factorisation are
    done once for any set of fixed parts.

    Parameters
    ----------
    count : number of poses
    d : scalars of a pose
    a, b : (m,) poses that each edge couples
    """

    def __init__(self, count: int, d: int, a: Ints, b: Ints) -> None:
        # Imported here, so that other models do not load it.
        from arael.runtime.linear.sparse import SparseSolver

        self.count, self.d, self.a, self.b = count, d, a, b
        pattern = BlockPattern.from_pairs(np.full(count, d, np.int64), a, b)
        # Two factorisations of it do not repay a comparison of orders.
        self._solver = SparseSolver(pattern, ordering="minimum_degree")
        self._size = pattern.value_count
        self._coupled = pattern.find(a, b)
        self._diagonal = pattern.value_start[pattern.column_start[:-1]]
        self._inside = np.arange(d * d)

    def solved(
        self, blocks: tuple[Array, Array, Array], own: Array, right: Array, held: Bools, at: Array
    ) -> Array:
        """Minimiser of the quadratic whose normal equations are given.

        Parameters
        ----------
        blocks : (m, d, d) of each edge: of `a` with `a`, of `a` with `b`, of `b` with `b`
        own : (count, d, d) additional diagonal blocks
        right : (count, d, k) right-hand sides
        held : (count,) fixed poses
        at : (count, d, k) values of fixed poses

        Returns
        -------
        (count, d, k)

        Raises
        ------
        SingularError
        """
        n, d, a, b = self.count, self.d, self.a, self.b
        aa, ab, bb = blocks
        square = np.where(held[:, None, None], 0.0, own)
        square = square + self.summed(a, np.where(held[a][:, None, None], 0.0, aa))
        square += self.summed(b, np.where(held[b][:, None, None], 0.0, bb))
        square[held] = np.eye(d)
        # Couplings with fixed poses are moved to the right-hand side.
        right = np.where(held[:, None, None], at, right)
        from_a, from_b = held[a] & ~held[b], held[b] & ~held[a]
        np.subtract.at(right, b[from_a], ab[from_a].transpose(0, 2, 1) @ at[a[from_a]])
        np.subtract.at(right, a[from_b], ab[from_b] @ at[b[from_b]])
        free = ~(held[a] | held[b])
        # A block is stored once, with the later pose as its rows.
        low = np.where((a > b)[:, None, None], ab, ab.transpose(0, 2, 1))
        low = np.where(free[:, None, None], low, 0.0)
        positions = np.concatenate((self._coupled, self._diagonal))[:, None] + self._inside
        values = np.bincount(
            positions.ravel(), np.concatenate((low, square)).ravel(), minlength=self._size
        )
        diagonal = np.ascontiguousarray(np.diagonal(square, axis1=1, axis2=2)).ravel()
        if not (diagonal > 0).all() or not np.isfinite(values).all():
            raise SingularError
        if self._solver.factorise(values, diagonal):
            raise SingularError
        solution = np.asarray(self._solver.solved(right.reshape(n * d, -1)), np.float64)
        if not np.isfinite(solution).all():
            raise SingularError
        return solution.reshape(n, d, -1)

    def summed(self, rows: Ints, blocks: Array) -> Array:
        """(count, ...) sums of the blocks of each row."""
        width = math.prod(blocks.shape[1:])
        positions = rows[:, None] * width + np.arange(width)
        flat: Array = np.zeros(self.count * width)
        if positions.size:  # bincount of an empty array returns integers
            flat += np.bincount(positions.ravel(), blocks.ravel(), minlength=self.count * width)
        return flat.reshape(self.count, *blocks.shape[1:])
