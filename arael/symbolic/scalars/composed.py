"""Functions of the language that are composed of operations.

The elementary ones follow IEEE arithmetic at their singular points. The ``safe_`` ones are finite
in value and derivative everywhere: outside their domain they are constant, which hides the
singularity from the solver; a constraint that avoids it is better.
"""

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


def clamp(g: Graph, x: int, low: int, high: int) -> int:
    """X held in low .. high."""
    return g.op("min", g.op("max", x, low), high)


def safe_sqrt(g: Graph, x: int) -> int:
    """Root of what is positive of x."""
    return g.op("sqrt", g.op("max", x, g.const(0.0)))


def _held(g: Graph, x: int) -> int:
    return g.op("min", g.op("max", x, g.const(-1.0)), g.const(1.0))


def safe_asin(g: Graph, x: int) -> int:
    """Arc sine of x held in -1 .. 1."""
    return g.op("asin", _held(g, x))


def safe_acos(g: Graph, x: int) -> int:
    """Arc cosine of x held in -1 .. 1."""
    return g.op("acos", _held(g, x))


def safe_atan2(g: Graph, y: int, x: int) -> int:
    """Arc tangent of two arguments; only its derivatives are regularised."""
    return g.op("atan2", y, x)


# gamma atan(r / gamma) is near r for small r and never exceeds gamma pi / 2, so no single residual
# costs more than (gamma pi / 2)^2. Its authors describe the method as patented (US 12,346,118).


def starship(g: Graph, r: int, gamma: int) -> int:
    """Gamma atan(r / gamma)."""
    return g.op("mul", gamma, g.op("atan", g.op("div", r, gamma)))


def starship_gamma(g: Graph, bound: int) -> int:
    """The gamma at which a residual costs at most `bound`."""
    return g.op("mul", g.const(2 / math.pi), g.op("sqrt", bound))
