"""Determinants and inverses of small matrices of graph nodes."""

from __future__ import annotations

from arael.manifolds.linear import Matrix, total
from arael.symbolic.graph import Graph

LARGEST_DETERMINANT = 4
LARGEST_INVERSE = 6


def _order(m: Matrix, largest: int, what: str) -> int:
    n = len(m)
    if any(len(row) != n for row in m):
        raise ValueError(f"the {what} needs a square matrix, not {n} x {len(m[0])}")
    if n > largest:
        raise ValueError(f"the {what} is worked out up to {largest} x {largest}, not {n} x {n}")
    return n


def _minor(m: Matrix, i: int, j: int) -> Matrix:
    return [row[:j] + row[j + 1 :] for k, row in enumerate(m) if k != i]


def _cofactor(g: Graph, m: Matrix, i: int, j: int) -> int:
    if len(m) == 1:
        return g.const(1.0)
    value = _laplace(g, _minor(m, i, j))
    return g.op("neg", value) if (i + j) % 2 else value


def _laplace(g: Graph, m: Matrix) -> int:
    if len(m) == 1:
        return m[0][0]
    return total(g, [g.op("mul", m[0][j], _cofactor(g, m, 0, j)) for j in range(len(m))])


def det(g: Graph, m: Matrix) -> int:
    """Return the determinant by expansion along the first row, up to 4 x 4."""
    _order(m, LARGEST_DETERMINANT, "determinant")
    return _laplace(g, m)


def inverse(g: Graph, m: Matrix) -> Matrix:
    """Inverse matrix, up to 6 x 6.

    Up to 3 x 3 the adjugate over the determinant. Above that Gauss-Jordan elimination that takes
    the pivots from the diagonal in order: right for symmetric definite and diagonally dominant
    matrices, not for those with a vanishing leading minor, which give NaN. A singular matrix gives
    NaN or infinities.
    """
    n = _order(m, LARGEST_INVERSE, "inverse")
    if n <= 3:
        reciprocal = g.op("div", g.const(1.0), _laplace(g, m))
        return [
            [g.op("mul", _cofactor(g, m, j, i), reciprocal) for j in range(n)] for i in range(n)
        ]
    work = [[*row, *(g.const(float(i == j)) for j in range(n))] for i, row in enumerate(m)]
    for k in range(n):
        reciprocal = g.op("div", g.const(1.0), work[k][k])
        work[k] = [g.op("mul", entry, reciprocal) for entry in work[k]]
        for i in range(n):
            if i != k:
                factor = work[i][k]
                work[i] = [
                    g.op("sub", entry, g.op("mul", factor, pivot))
                    for entry, pivot in zip(work[i], work[k], strict=True)
                ]
    return [row[n:] for row in work]
