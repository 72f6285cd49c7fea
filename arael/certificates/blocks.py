"""Sparse matrices by blocks, factorised by the solver of the runtime."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.linear.analysis import analyse
from arael.runtime.linear.compiled import SparseSolver

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class BlockMatrix:
    """Factorisations of matrices on the blocks of a chordal problem.

    Parameters
    ----------
    blocks : (k,) number of columns of each block
    q : a matrix with all entries that the others have
    """

    def __init__(self, blocks: Ints, q: Any) -> None:
        entries = q.tocoo()
        ends = np.cumsum(blocks)
        first = ends - blocks
        of_row = np.searchsorted(ends, entries.row, side="right")
        of_column = np.searchsorted(ends, entries.col, side="right")
        self._pattern = BlockPattern.from_pairs(blocks, of_row, of_column)
        self._analysis = analyse(self._pattern, "minimum_degree")
        self._first, self._ends, self._blocks = first, ends, blocks
        self.mean = float(q.diagonal().mean())
        self._last: tuple[Any, Any, Any, Ints] | None = None

    def factorised(self, matrix: Any, shift: Floats) -> SparseSolver | None:
        """A factor of ``matrix + diag(shift)``; None if it is not positive definite."""
        lower, place = self._places(matrix)
        values = np.zeros(self._pattern.value_count)
        values[place] = matrix.data[lower]
        solver = SparseSolver(self._pattern, analysis=self._analysis)
        diagonal = np.asarray(matrix.diagonal()) + shift
        return None if (diagonal <= 0).any() or solver.factorise(values, diagonal) else solver

    def _places(self, matrix: Any) -> tuple[Any, Ints]:
        """Which entries are in the lower triangle, and where; kept for the next of this pattern."""
        if self._last is not None:
            indptr, indices, lower, place = self._last
            if np.array_equal(indptr, matrix.indptr) and np.array_equal(indices, matrix.indices):
                return lower, place
        entries = matrix.tocoo()
        lower = entries.row >= entries.col
        row, column = entries.row[lower], entries.col[lower]
        i = np.searchsorted(self._ends, row, side="right")
        j = np.searchsorted(self._ends, column, side="right")
        start = self._pattern.find(i, j)
        place = start + (row - self._first[i]) * self._blocks[j] + column - self._first[j]
        self._last = matrix.indptr, matrix.indices, lower, place
        return lower, place
