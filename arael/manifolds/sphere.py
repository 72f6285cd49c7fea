"""The unit sphere on graph nodes: a basis of the tangent plane, and steps along great circles."""

from __future__ import annotations

from collections.abc import Sequence

from arael.manifolds.linear import Matrix, Vector, add, dot, matvec, norm2, scale, transpose, unit
from arael.symbolic import series
from arael.symbolic.graph import Graph


def basis(g: Graph, d: Sequence[int]) -> Matrix:
    """Columns u, v (3 x 2) that complete the unit vector `d` to a right-handed frame u, v, d.

    Without roots, and defined everywhere. T. Duff and others, "Building an Orthonormal Basis,
    Revisited", Journal of Computer Graphics Techniques 6 (2017).
    """
    x, y, z = d
    one = g.const(1.0)
    sign = g.op("select", g.op("lt", z, g.const(0.0)), g.const(-1.0), one)
    a = g.op("neg", g.op("div", one, g.op("add", sign, z)))
    b = g.op("mul", g.op("mul", x, y), a)
    xx, yy = g.op("mul", g.op("mul", x, x), a), g.op("mul", g.op("mul", y, y), a)
    u = [
        g.op("add", one, g.op("mul", sign, xx)),
        g.op("mul", sign, b),
        g.op("neg", g.op("mul", sign, x)),
    ]
    v = [b, g.op("add", sign, yy), g.op("neg", y)]
    return [list(row) for row in zip(u, v, strict=True)]


def move(g: Graph, d: Sequence[int], delta: Sequence[int]) -> Vector:
    """Go from `d` along the great circle of the tangent vector B delta, by its length (rad).

    ``cos(|delta|) d + sin(|delta|)/|delta| B delta``, normalised.
    """
    t2 = norm2(g, delta)
    along = scale(g, series.sinc(g, t2), matvec(g, basis(g, d), delta))
    return unit(g, add(g, scale(g, series.cosine(g, t2), d), along))


def log(g: Graph, mean: Sequence[int], d: Sequence[int]) -> Vector:
    """Tangent vector at `mean` whose great circle leads to `d`: the inverse of `move`.

    ``B'd * angle / sin(angle)`` with angle = atan2(|B'd|, mean . d); near `mean` by the series of
    the arc sine in s = |B'd|^2. At the opposite point the way is undetermined, and the value is 0.
    """
    flat = matvec(g, transpose(basis(g, mean)), d)
    s = norm2(g, flat)
    ahead = dot(g, mean, d)
    near = g.op("lt", s, g.const(_SMALL_SINE_SQUARED))
    small = g.op("and", near, g.op("lt", g.const(0.0), ahead))
    away = g.op("max", s, g.const(_LEAST_SQUARE))
    sine = g.op("sqrt", g.op("select", small, g.const(1.0), away))
    closed = g.op("div", g.op("atan2", sine, ahead), sine)
    factor = g.op("select", small, series.polynomial(g, s, _ARC_SINE), closed)
    return scale(g, factor, flat)


_SMALL_SINE_SQUARED = 1e-4
_LEAST_SQUARE = 1e-30
_ARC_SINE = (1.0, 1 / 6, 3 / 40, 5 / 112, 35 / 1152)
