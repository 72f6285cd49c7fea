"""Angles that wrap, and fast arc tangents."""

from __future__ import annotations

import math

from arael.symbolic.graph import Graph
from arael.symbolic.scalars.function import ScalarFunction, prescribed

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


def _rad_diff(g: Graph, a: int, b: int) -> int:
    return wrap(g, g.op("sub", a, b))


def _rad_sum(g: Graph, a: int, b: int) -> int:
    return wrap(g, g.op("add", a, b))


def _fast_atan_unit(g: Graph, x: int) -> int:
    """Evaluate the polynomial, for |x| <= 1."""
    square = g.op("mul", x, x)
    result = g.const(FAST_ATAN_COEFFICIENTS[-1])
    for coefficient in reversed(FAST_ATAN_COEFFICIENTS[:-1]):
        result = g.op("add", g.const(coefficient), g.op("mul", square, result))
    return g.op("mul", x, result)


def _fast_atan(g: Graph, x: int) -> int:
    one = g.const(1.0)
    steep = g.op("lt", one, g.op("abs", x))
    reduced = g.op("select", steep, g.op("div", one, g.op("select", steep, x, one)), x)
    inner = _fast_atan_unit(g, reduced)
    quarter = g.op("mul", g.const(math.pi / 2), g.op("sign", x))
    return g.op("select", steep, g.op("sub", quarter, inner), inner)


def _fast_atan2(g: Graph, y: int, x: int) -> int:
    one, zero = g.const(1.0), g.const(0.0)
    across, along = g.op("abs", y), g.op("abs", x)
    larger, smaller = g.op("max", across, along), g.op("min", across, along)
    divisor = g.op("select", g.op("eq", larger, zero), one, larger)
    angle = _fast_atan_unit(g, g.op("div", smaller, divisor))
    steep, back = g.op("lt", along, across), g.op("lt", x, zero)
    angle = g.op("select", steep, g.op("sub", g.const(math.pi / 2), angle), angle)
    angle = g.op("select", back, g.op("sub", g.const(math.pi), angle), angle)
    return g.op("select", g.op("lt", y, zero), g.op("neg", angle), angle)


FUNCTIONS = (
    ScalarFunction(
        "rad_diff",
        2,
        _rad_diff,
        "x - y, wrapped to (-pi, pi]",
        "1; -1",
        "pi at a half turn, from either side; derivatives 1 and -1 there too",
    ),
    ScalarFunction(
        "rad_sum",
        2,
        _rad_sum,
        "x + y, wrapped to (-pi, pi]",
        "1; 1",
        "pi at a half turn, from either side; derivatives 1 and 1 there too",
    ),
    prescribed(
        "fast_atan",
        1,
        _fast_atan,
        "atan(x) to within 6e-8, by a polynomial",
        "1 / (1 + x^2)",
        "jumps by less than 1e-7 at |x| = 1",
    ),
    prescribed(
        "fast_atan2",
        2,
        _fast_atan2,
        "atan2(x, y) to within 6e-8, by a polynomial",
        "y / (x^2 + y^2); -x / (x^2 + y^2)",
        "0 at (0, 0) with derivative NaN; jumps by less than 1e-7 at |x| = |y|",
    ),
)
