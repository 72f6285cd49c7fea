"""Selected inverse: entries of the inverse on the pattern of the factor.

With ``H = L L'`` the inverse Z obeys ``Z = L^-T L^-1`` on its upper triangle and is symmetric, so
that its entries on the pattern of L can be computed from the last column to the first without any
others:

    Z_rc = -Z_rr Y,    Z_cc = (L_cc L_cc')^-1 - Y' Z_rc,    Y = L_rc L_cc^-1

for the columns c of a front and the rows r below them. K. Takahashi, J. Fagan, M. Chin, "Formation
of a sparse bus impedance matrix and its application to short circuit study" (1973); by fronts as in
L. Lin et al., "SelInv", ACM TOMS 37 (2011). On a chain of entities this is the backward sweep that
follows the forward sweep of the factorisation.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from arael.runtime.linear.compiled import SparseSolver

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class SelectedInverse:
    """Blocks of the inverse of a factorised matrix on the pattern of the factor.

    Parameters
    ----------
    solver : after a successful factorisation

    Time and memory are those of a factorisation.
    """

    def __init__(self, solver: SparseSolver) -> None:
        table, storage, runs, strips, scalar = solver.parts()
        self._place = np.empty_like(scalar)
        self._place[scalar] = np.arange(len(scalar))
        ends = table[:, 14]
        self._first = table[1:, 4]
        self._columns = table[1:, 0]
        self._rows = [_spread(strips[ends[s] : ends[s + 1]]) for s in range(len(table) - 1)]
        self._blocks = _backward(table, storage, runs, self._rows)

    def block(self, a: Ints, b: Ints) -> Floats | None:
        """(len(a), len(b)) entries between scalars `a` and `b`; None if the factor lacks some."""
        found = np.empty((len(a), len(b)))
        rows, columns = self._place[a], self._place[b]
        for i, row in enumerate(rows):
            for j, column in enumerate(columns):
                value = self._entry(min(row, column), max(row, column))
                if value is None:
                    return None
                found[i, j] = value
        return found

    def diagonal_blocks(self, first: Ints, size: int) -> Floats:
        """(m, size, size) blocks of consecutive scalars that begin at `first` (m,).

        They must lie in one entity each, so that the factor has them.
        """
        found = np.empty((len(first), size, size))
        for k, start in enumerate(first):
            place = int(self._place[start])
            front = int(np.searchsorted(self._first, place, side="right")) - 1
            at = place - int(self._first[front])
            found[k] = self._blocks[front][at : at + size, at : at + size]
        return found

    def entries(self, scalars: Ints) -> Floats:
        """(m, k, k) entries between the scalars (m, k) of each row; 0 where the factor has none."""
        places = self._place[scalars]
        low = np.minimum(places[:, :, None], places[:, None, :]).ravel()
        high = np.maximum(places[:, :, None], places[:, None, :]).ravel()
        keys, values = self._sorted
        at = np.searchsorted(keys, low * len(self._place) + high)
        at = np.minimum(at, len(keys) - 1)
        there = keys[at] == low * len(self._place) + high
        found = np.where(there, values[at], 0.0)
        return found.reshape(*scalars.shape, scalars.shape[1])

    @cached_property
    def _sorted(self) -> tuple[Ints, Floats]:
        """Keys ``column n + row`` of all entries of the lower triangle, ascending, and values."""
        n = len(self._place)
        keys, values = [], []
        for first, count, below, block in zip(
            self._first, self._columns, self._rows, self._blocks, strict=True
        ):
            columns = first + np.arange(count)
            rows = np.concatenate([columns, below])
            keys.append((columns[:, None] * n + rows).ravel())
            values.append(block.T.ravel())
        key = np.concatenate(keys)
        order = np.argsort(key, kind="stable")
        return key[order], np.concatenate(values)[order]

    def diagonal(self) -> Floats:
        """(n,) diagonal of the inverse."""
        parts = [b.diagonal() for b in self._blocks]
        return np.concatenate([np.zeros(0), *parts])[self._place]

    def _entry(self, low: int, high: int) -> float | None:
        front = int(np.searchsorted(self._first, low, side="right")) - 1
        column = low - int(self._first[front])
        row = high - int(self._first[front])
        if row >= self._columns[front]:
            rows = self._rows[front]
            at = int(np.searchsorted(rows, high))
            if at == len(rows) or rows[at] != high:
                return None
            row = int(self._columns[front]) + at
        return float(self._blocks[front][row, column])


def _backward(
    table: Ints, storage: NDArray[np.floating], runs: NDArray[np.int32], rows: list[Ints]
) -> list[Floats]:
    """Z of each front: its (k + r, k) columns, in the order of the fronts."""
    # Imported here for start-up time: most solves need no covariances.
    from scipy.linalg.lapack import dtrtri

    count = len(rows)
    found: list[Floats] = [np.zeros((0, 0))] * count
    # Squares of the fronts on the path from the root: children read the square of their rows.
    whole: list[Floats | None] = [None] * count
    waiting = np.diff(table[:, 11])
    parent = _parents(table, rows)
    for s in range(count - 1, -1, -1):
        k, r, tall, low = (int(x) for x in table[s + 1, :4])
        at, panel = int(table[s + 1, 5]), int(table[s + 1, 6])
        triangle = storage[at : at + k * tall].reshape(k, tall)[:, :k].T
        inverse = np.tril(dtrtri(np.tril(triangle).astype(np.float64), lower=1)[0])
        square = inverse.T @ inverse
        columns = np.empty((k + r, k))
        columns[:k] = square
        up = parent[s]
        if r:
            above = whole[up]
            assert above is not None
            below = storage[panel : panel + k * low].reshape(k, low)[:, :r].T
            local = _spread(runs[table[s, 13] : table[s + 1, 13], 1:][:, ::-1])
            y = below @ inverse
            around = above[np.ix_(local, local)]
            columns[k:] = -around @ y
            columns[:k] -= y.T @ columns[k:]
        if waiting[s]:
            full = np.empty((k + r, k + r))
            full[:, :k] = columns
            full[:k, k:] = columns[k:].T
            if r:
                full[k:, k:] = around
            whole[s] = full
        if up >= 0:
            waiting[up] -= 1
            if not waiting[up]:
                whole[up] = None
        found[s] = columns
    return found


def _parents(table: Ints, rows: list[Ints]) -> list[int]:
    """Front that has the first row of each front as a column; -1 for roots."""
    first = table[1:, 4]
    return [int(np.searchsorted(first, r[0], side="right")) - 1 if len(r) else -1 for r in rows]


def _spread(ranges: NDArray[np.int32]) -> Ints:
    """Indices of ranges given as (first, count)."""
    if len(ranges) == 1:
        first, count = (int(x) for x in ranges[0])
        return np.arange(first, first + count)
    parts = [np.arange(first, first + count) for first, count in ranges.tolist()]
    return np.concatenate([np.zeros(0, dtype=np.int64), *parts])
