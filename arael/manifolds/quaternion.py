"""Quaternions on graph nodes: lists (w, x, y, z), scalar first, Hamilton's product.

A unit quaternion turns body vectors into world vectors: v_world = q v_body q*. Logarithm and
exponential are rotation vectors (axis times angle, rad), smooth at the identity.
"""

from __future__ import annotations

from collections.abc import Sequence

from arael.manifolds.linear import (
    Matrix,
    Vector,
    add,
    cross,
    dot,
    norm2,
    scale,
    unit,
)
from arael.symbolic.graph import Graph
from arael.symbolic.series import polynomial

# Below these the series are exact to rounding, and the closed forms lose accuracy in derivatives.
_SMALL_SINE_SQUARED = 1e-5
_SMALL_ANGLE_SQUARED = 1e-3


def product(g: Graph, p: Sequence[int], q: Sequence[int]) -> Vector:
    """Hamilton product p q: first turn by q, then by p."""
    pw, pv, qw, qv = p[0], p[1:], q[0], q[1:]
    scalar = g.op("sub", g.op("mul", pw, qw), dot(g, pv, qv))
    vector = add(g, add(g, scale(g, pw, qv), scale(g, qw, pv)), cross(g, pv, qv))
    return [scalar, *vector]


def conj(g: Graph, q: Sequence[int]) -> Vector:
    """Conjugate (w, -x, -y, -z): of a unit quaternion, the inverse."""
    return [q[0], *(g.op("neg", x) for x in q[1:])]


def inverse(g: Graph, q: Sequence[int]) -> Vector:
    """Inverse q* / |q|^2 of any quaternion but zero."""
    return scale(g, g.op("div", g.const(1.0), norm2(g, q)), conj(g, q))


def normalized(g: Graph, q: Sequence[int]) -> Vector:
    """Return the unit quaternion along `q`; NaN for zero."""
    return unit(g, q)


def rotate(g: Graph, q: Sequence[int], v: Sequence[int]) -> Vector:
    """Turn the 3-vector `v` by unit quaternion `q`: v + w t + u x t, u = vec q, t = 2 u x v."""
    u = q[1:]
    t = scale(g, g.const(2.0), cross(g, u, v))
    return add(g, add(g, v, scale(g, q[0], t)), cross(g, u, t))


def rotation_matrix(g: Graph, q: Sequence[int]) -> Matrix:
    """Rotation matrix of a unit quaternion, body to world."""
    w, x, y, z = q
    one, two = g.const(1.0), g.const(2.0)

    def twice(a: int, b: int) -> int:
        return g.op("mul", two, g.op("mul", a, b))

    def diagonal(a: int, b: int) -> int:
        squares = g.op("add", g.op("mul", a, a), g.op("mul", b, b))
        return g.op("sub", one, g.op("mul", two, squares))

    xy, xz, yz = twice(x, y), twice(x, z), twice(y, z)
    wx, wy, wz = twice(w, x), twice(w, y), twice(w, z)
    return [
        [diagonal(y, z), g.op("sub", xy, wz), g.op("add", xz, wy)],
        [g.op("add", xy, wz), diagonal(x, z), g.op("sub", yz, wx)],
        [g.op("sub", xz, wy), g.op("add", yz, wx), diagonal(x, y)],
    ]


def exp(g: Graph, v: Sequence[int]) -> Vector:
    """Return the unit quaternion of the rotation vector `v` (rad), (cos(t/2), v sin(t/2)/t).

    Here t = |v|. Near zero by the series in h = (t/2)^2, so value and derivative are right at the
    identity.
    """
    h = g.op("mul", g.const(0.25), norm2(g, v))
    small = g.op("lt", h, g.const(_SMALL_ANGLE_SQUARED))
    # The closed form is kept away from zero, so that its unused derivative is finite too.
    half = g.op("sqrt", g.op("select", small, g.const(1.0), h))
    cosine = g.op("select", small, polynomial(g, h, _COS), g.op("cos", half))
    sinc = g.op("select", small, polynomial(g, h, _SINC), g.op("div", g.op("sin", half), half))
    return [cosine, *scale(g, g.op("mul", g.const(0.5), sinc), v)]


def log(g: Graph, q: Sequence[int]) -> Vector:
    """Rotation vector (rad) of a unit quaternion, of length at most pi: q and -q give the same.

    Near the identity by the series 2/w (1 - s/3 + s^2/5 - s^3/7) of 2 atan(sqrt(s))/sqrt(s)/w with
    s = |vec q|^2 / w^2; right there in value and derivative. At the half turn, where q and -q meet,
    it jumps between opposite vectors.
    """
    negative = g.op("lt", q[0], g.const(0.0))
    w = g.op("abs", q[0])
    n2 = norm2(g, q[1:])
    small = g.op("lt", n2, g.const(_SMALL_SINE_SQUARED))
    one = g.const(1.0)
    n = g.op("sqrt", g.op("select", small, one, n2))
    closed = g.op("div", g.op("mul", g.const(2.0), g.op("atan2", n, w)), n)
    near_w = g.op("select", small, w, one)
    s = g.op("div", n2, g.op("mul", near_w, near_w))
    series = g.op("div", polynomial(g, s, _TWICE_ATAN), near_w)
    factor = g.op("select", small, series, closed)
    return scale(g, g.op("select", negative, g.op("neg", factor), factor), q[1:])


_COS = (1.0, -1 / 2, 1 / 24, -1 / 720, 1 / 40320)
_SINC = (1.0, -1 / 6, 1 / 120, -1 / 5040, 1 / 362880)
_TWICE_ATAN = (2.0, -2 / 3, 2 / 5, -2 / 7)


def from_rotation_matrix(g: Graph, m: Matrix) -> Vector:
    """Return the unit quaternion of a rotation matrix, w > 0 for turns below 120 degrees.

    Shepperd's method: of the four squares 4w^2, 4x^2, 4y^2, 4z^2 the largest is at least 1, and the
    others follow from it by division, so it is accurate for every rotation. Beyond 120 degrees the
    component divided by is the largest of x, y, z, and positive.
    """
    one = g.const(1.0)
    a, b, c = m[0][0], m[1][1], m[2][2]
    wx, wy, wz = (g.op("sub", m[i][j], m[j][i]) for i, j in ((2, 1), (0, 2), (1, 0)))
    xy, xz, yz = (g.op("add", m[i][j], m[j][i]) for i, j in ((1, 0), (0, 2), (2, 1)))
    ww = g.op("add", one, g.op("add", g.op("add", a, b), c))
    xx = g.op("add", one, g.op("sub", g.op("sub", a, b), c))
    yy = g.op("add", one, g.op("sub", g.op("sub", b, a), c))
    zz = g.op("add", one, g.op("sub", g.op("sub", c, a), b))
    # w serves for all turns below 120 degrees; beyond, the largest of the other three.
    use_w = g.op("le", one, ww)
    use_x = g.op("and", g.op("le", yy, xx), g.op("le", zz, xx))
    use_y = g.op("le", zz, yy)

    def pick(for_w: int, for_x: int, for_y: int, for_z: int) -> int:
        last = g.op("select", use_y, for_y, for_z)
        return g.op("select", use_w, for_w, g.op("select", use_x, for_x, last))

    columns = ((ww, wx, wy, wz), (wx, xx, xy, xz), (wy, xy, yy, yz), (wz, xz, yz, zz))
    chosen = [pick(*column) for column in columns]
    factor = g.op("div", g.const(0.5), g.op("sqrt", pick(ww, xx, yy, zz)))
    return scale(g, factor, chosen)
