"""The unit sphere on graph nodes: a basis of the tangent plane, and steps along great circles."""

from __future__ import annotations

from collections.abc import Sequence

from arael.symbolic import series
from arael.symbolic.graph import Graph
from arael.symbolic.linear import Matrix, Vector, add, matvec, norm2, scale, unit


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
