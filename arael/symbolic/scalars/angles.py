"""Angles that wrap, and fast arc tangents."""

from __future__ import annotations

import math

from arael.symbolic.graph import Graph
from arael.symbolic.series import polynomial

# Minimax fit of atan(x)/x - 1 in powers of x^2 on 0 .. 1 (Lawson's reweighting); largest error of
# atan 5.03e-8. The leading 1 keeps value and slope exact at 0.
FAST_ATAN_COEFFICIENTS = (
    1.0,
    -0.33331659,
    0.19962704,
    -0.139765819,
    0.0979423402,
    -0.0577735816,
    0.0230401298,
    -0.00435540399,
)


def wrap(g: Graph, angle: int) -> int:
    """`angle` less the whole turns that bring it into (-pi, pi]; slope 1."""
    turn = g.const(2 * math.pi)
    turns = g.op("ceil", g.op("div", g.op("sub", angle, g.const(math.pi)), turn))
    return g.op("sub", angle, g.op("mul", turn, turns))


def rad_diff(g: Graph, a: int, b: int) -> int:
    """Difference of angles, wrapped to (-pi, pi]."""
    return wrap(g, g.op("sub", a, b))


def rad_sum(g: Graph, a: int, b: int) -> int:
    """Sum of angles, wrapped to (-pi, pi]."""
    return wrap(g, g.op("add", a, b))


def _fast_atan_unit(g: Graph, x: int) -> int:
    """Evaluate the polynomial, for |x| <= 1."""
    return g.op("mul", x, polynomial(g, g.op("mul", x, x), FAST_ATAN_COEFFICIENTS))


def fast_atan(g: Graph, x: int) -> int:
    """Arc tangent by the polynomial, of x or of its reciprocal."""
    one = g.const(1.0)
    steep = g.op("lt", one, g.op("abs", x))
    reduced = g.op("select", steep, g.op("div", one, g.op("select", steep, x, one)), x)
    inner = _fast_atan_unit(g, reduced)
    quarter = g.op("mul", g.const(math.pi / 2), g.op("sign", x))
    return g.op("select", steep, g.op("sub", quarter, inner), inner)


def fast_atan2(g: Graph, y: int, x: int) -> int:
    """Angle of the vector (x, y) by the polynomial."""
    one, zero = g.const(1.0), g.const(0.0)
    across, along = g.op("abs", y), g.op("abs", x)
    larger, smaller = g.op("max", across, along), g.op("min", across, along)
    divisor = g.op("select", g.op("eq", larger, zero), one, larger)
    angle = _fast_atan_unit(g, g.op("div", smaller, divisor))
    steep, back = g.op("lt", along, across), g.op("lt", x, zero)
    angle = g.op("select", steep, g.op("sub", g.const(math.pi / 2), angle), angle)
    angle = g.op("select", back, g.op("sub", g.const(math.pi), angle), angle)
    return g.op("select", g.op("lt", y, zero), g.op("neg", angle), angle)
