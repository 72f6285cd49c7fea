"""Matrices whose rank and null spaces are tested."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from hypothesis import strategies as st
from numpy.typing import NDArray

from arael.runtime.orthogonal import RankQR

Doubles = NDArray[np.float64]
Row = tuple[list[int], list[float]]


class Sparse(NamedTuple):
    """A matrix in compressed rows."""

    m: int
    n: int
    indptr: NDArray[np.int32]
    indices: NDArray[np.int32]
    entries: Doubles

    def analysed(self, **options: object) -> RankQR:
        return RankQR(*self[:4], **options)  # type: ignore[arg-type]

    def factored(self, scale: Doubles | None = None) -> RankQR:
        found = self.analysed()
        found.factor(self.entries, scale)
        return found

    def row(self, i: int) -> tuple[NDArray[np.int32], Doubles]:
        part = slice(self.indptr[i], self.indptr[i + 1])
        return self.indices[part], self.entries[part]

    def times(self, x: Doubles) -> Doubles:
        sums = np.zeros(self.m)
        np.add.at(
            sums, np.repeat(np.arange(self.m), np.diff(self.indptr)), self.entries * x[self.indices]
        )
        return sums


def sparse(dense: Doubles) -> Sparse:
    rows, columns = np.nonzero(dense)
    indptr = np.concatenate([[0], np.cumsum((dense != 0).sum(axis=1))])
    return Sparse(
        len(dense),
        dense.shape[1],
        indptr.astype(np.int32),
        columns.astype(np.int32),
        dense[rows, columns],
    )


def of_rows(n: int, rows: list[Row]) -> Sparse:
    indptr = np.concatenate([[0], np.cumsum([len(at) for at, _ in rows])]).astype(np.int32)
    indices = np.array([u for at, _ in rows for u in at], dtype=np.int32)
    return Sparse(len(rows), n, indptr, indices, np.array([v for _, w in rows for v in w], float))


@st.composite
def integer_matrices(draw: st.DrawFn, rows: int = 10, columns: int = 10) -> Doubles:
    """Small integers, sparse to full; some rows are sums of others, or repeated, or zero."""
    m, n = draw(st.integers(0, rows)), draw(st.integers(0, columns))
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    share = draw(st.sampled_from([0.15, 0.3, 0.6, 1.0]))
    dense = rng.integers(-2, 3, (m, n)) * (rng.random((m, n)) < share)
    for _ in range(draw(st.integers(0, 3)) if m else 0):
        i, j, k = rng.integers(m, size=3)
        dense[i] = dense[j] - 2 * dense[k] if rng.random() < 0.7 else dense[j]
    return dense.astype(float)


def chain(count: int) -> Sparse:
    """`x[0]` and the differences of neighbours: singular values down to about 1.6 / count."""
    rows: list[Row] = [([0], [1.0])]
    rows += [([i, i + 1], [-1.0, 1.0]) for i in range(count - 1)]
    return of_rows(count, rows)


def beams(count: int) -> Sparse:
    """Differences of second order: singular values down to about count**-2 / 0.3."""
    rows: list[Row] = [([0], [1.0]), ([1], [1.0])]
    rows += [([i, i + 1, i + 2], [1.0, -2.0, 1.0]) for i in range(count - 2)]
    return of_rows(count, rows)


def grid(count: int) -> Sparse:
    """Differences along all edges of a square grid of points: (count - 1)**2 are dependent."""
    rows: list[Row] = []
    for i in range(count):
        for j in range(count):
            k = i * count + j
            if i + 1 < count:
                rows.append(([k, k + count], [-1.0, 1.0]))
            if j + 1 < count:
                rows.append(([k, k + 1], [-1.0, 1.0]))
    return of_rows(count * count, rows)


def polygon(corners: int) -> Sparse:
    """A closed polygon of equal sides: differences of the squared lengths of neighbouring sides."""
    angle = 2 * np.pi * np.arange(corners) / corners
    points = np.column_stack([np.cos(angle), np.sin(angle)])
    rows: list[Row] = []
    for i in range(corners - 1):
        a, b, c = i, (i + 1) % corners, (i + 2) % corners
        u, v = points[b] - points[a], points[c] - points[b]
        at = [2 * a, 2 * a + 1, 2 * b, 2 * b + 1, 2 * c, 2 * c + 1]
        rows.append((at, [*-u, *(u + v), *-v]))
    return of_rows(2 * corners, rows)
