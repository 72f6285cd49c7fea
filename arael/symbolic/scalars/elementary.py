"""Elementary functions: IEEE arithmetic at their singular points, nothing is hidden there."""

from __future__ import annotations

import math

from arael.symbolic import series
from arael.symbolic.graph import Graph


def deg2rad(g: Graph, x: int) -> int:
    """Radians of degrees."""
    return g.op("mul", g.const(math.pi / 180), x)


def rad2deg(g: Graph, x: int) -> int:
    """Degrees of radians."""
    return g.op("mul", g.const(180 / math.pi), x)


def sinc(g: Graph, x: int) -> int:
    """sin(x) / x by its series near 0."""
    return series.sinc(g, g.op("mul", x, x))


# Bernoulli numbers B_2k / 2k, k = 1 .. 6: Abramowitz and Stegun, Handbook, 6.3.18.
_BERNOULLI = (1 / 12, -1 / 120, 1 / 252, -1 / 240, 1 / 132, -691 / 32760)
_SHIFT = 10


def digamma(g: Graph, x: int) -> int:
    """Take the asymptotic series beyond 10, recurrence below it, reflection below 0."""
    one, zero = g.const(1.0), g.const(0.0)
    negative = g.op("lt", x, zero)
    y = g.op("select", negative, g.op("sub", one, x), x)
    far = g.op("add", y, g.const(float(_SHIFT)))
    reciprocal = g.op("div", one, far)
    rest = g.op("mul", reciprocal, reciprocal)
    tail = g.op("mul", rest, series.polynomial(g, rest, _BERNOULLI))
    value = g.op("sub", g.op("log", far), g.op("mul", g.const(0.5), reciprocal))
    value = g.op("sub", value, tail)
    for k in range(_SHIFT):
        value = g.op("sub", value, g.op("div", one, g.op("add", y, g.const(float(k)))))
    pi = g.const(math.pi)
    angle = g.op("select", negative, g.op("mul", pi, x), one)
    reflected = g.op("sub", value, g.op("div", pi, g.op("tan", angle)))
    return g.op("select", negative, reflected, value)
