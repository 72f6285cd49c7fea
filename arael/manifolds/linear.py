"""Small dense linear algebra on graph nodes.

A vector is a list of nodes, a matrix a list of rows. Everything is written out in full, so these
are for the sizes that occur in residuals.
"""

from __future__ import annotations

from collections.abc import Sequence

from arael.symbolic.graph import Graph

Vector = list[int]
Matrix = list[list[int]]


def matrix(entries: Sequence[int], rows: int, columns: int) -> Matrix:
    """Make a `rows` x `columns` matrix of entries listed row by row."""
    if len(entries) != rows * columns:
        raise ValueError(f"{len(entries)} entries do not fill a {rows} x {columns} matrix")
    return [list(entries[i * columns : (i + 1) * columns]) for i in range(rows)]


def flatten(m: Matrix) -> Vector:
    """Entries row by row."""
    return [entry for row in m for entry in row]


def constants(g: Graph, values: Sequence[float]) -> Vector:
    """Make a vector of literal values."""
    return [g.const(value) for value in values]


def identity(g: Graph, n: int) -> Matrix:
    """Identity matrix."""
    return [[g.const(float(i == j)) for j in range(n)] for i in range(n)]


def zeros(g: Graph, rows: int, columns: int) -> Matrix:
    """Zero matrix."""
    return [[g.const(0.0)] * columns for _ in range(rows)]


def total(g: Graph, terms: Sequence[int]) -> int:
    """Sum, from the left; 0 of nothing."""
    if not terms:
        return g.const(0.0)
    result = terms[0]
    for term in terms[1:]:
        result = g.op("add", result, term)
    return result


def elementwise(g: Graph, name: str, a: Sequence[int], b: Sequence[int]) -> Vector:
    """Operation `name` on each pair of entries."""
    return [g.op(name, x, y) for x, y in zip(a, b, strict=True)]


def add(g: Graph, a: Sequence[int], b: Sequence[int]) -> Vector:
    """Sum of two vectors."""
    return elementwise(g, "add", a, b)


def sub(g: Graph, a: Sequence[int], b: Sequence[int]) -> Vector:
    """Difference of two vectors."""
    return elementwise(g, "sub", a, b)


def neg(g: Graph, a: Sequence[int]) -> Vector:
    """Opposite vector."""
    return [g.op("neg", x) for x in a]


def scale(g: Graph, factor: int, a: Sequence[int]) -> Vector:
    """Scalar times vector."""
    return [g.op("mul", factor, x) for x in a]


def divide(g: Graph, a: Sequence[int], divisor: int) -> Vector:
    """Vector divided by a scalar."""
    return [g.op("div", x, divisor) for x in a]


def dot(g: Graph, a: Sequence[int], b: Sequence[int]) -> int:
    """Inner product."""
    return total(g, elementwise(g, "mul", a, b))


def norm2(g: Graph, a: Sequence[int]) -> int:
    """Squared Euclidean norm."""
    return dot(g, a, a)


def norm(g: Graph, a: Sequence[int]) -> int:
    """Euclidean norm. Its derivative at the zero vector is NaN."""
    return g.op("abs", a[0]) if len(a) == 1 else g.op("sqrt", norm2(g, a))


def unit(g: Graph, a: Sequence[int]) -> Vector:
    """Vector of length 1 in the direction of `a`; NaN for the zero vector."""
    reciprocal = g.op("div", g.const(1.0), norm(g, a))
    return scale(g, reciprocal, a)


def perp(g: Graph, a: Sequence[int]) -> Vector:
    """Turn a 2-vector left by a right angle: (-y, x)."""
    x, y = a
    return [g.op("neg", y), x]


def cross(g: Graph, a: Sequence[int], b: Sequence[int]) -> Vector:
    """Cross product of 3-vectors."""
    return [
        g.op("sub", g.op("mul", a[i], b[j]), g.op("mul", a[j], b[i]))
        for i, j in ((1, 2), (2, 0), (0, 1))
    ]


def transpose(m: Matrix) -> Matrix:
    """Transposed matrix."""
    return [list(column) for column in zip(*m, strict=True)]


def matmul(g: Graph, a: Matrix, b: Matrix) -> Matrix:
    """Matrix product."""
    columns = transpose(b)
    return [[dot(g, row, column) for column in columns] for row in a]


def matvec(g: Graph, m: Matrix, v: Sequence[int]) -> Vector:
    """Matrix times column vector."""
    return [dot(g, row, v) for row in m]


def outer(g: Graph, a: Sequence[int], b: Sequence[int]) -> Matrix:
    """Column times row: a b'."""
    return [scale(g, x, b) for x in a]


def trace(g: Graph, m: Matrix) -> int:
    """Sum of the diagonal."""
    return total(g, [m[i][i] for i in range(len(m))])


def skew(g: Graph, v: Sequence[int]) -> Matrix:
    """Return the matrix [v]x with [v]x w = v x w."""
    x, y, z = v
    zero = g.const(0.0)
    return [
        [zero, g.op("neg", z), y],
        [z, zero, g.op("neg", x)],
        [g.op("neg", y), x, zero],
    ]


def vee(g: Graph, m: Matrix) -> Vector:
    """Inverse of `skew`; of a general matrix, of its antisymmetric part (M - M') / 2."""
    half = g.const(0.5)
    return [g.op("mul", half, g.op("sub", m[i][j], m[j][i])) for i, j in ((2, 1), (0, 2), (1, 0))]
