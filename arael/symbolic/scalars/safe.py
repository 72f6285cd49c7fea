"""Regularised functions: finite in value and derivative everywhere.

They hide a singularity from the solver; a constraint that avoids it is better. Outside their domain
they are constant, and so is what the solver sees of them there.
"""

from __future__ import annotations

from arael.symbolic.graph import Graph
from arael.symbolic.scalars.function import REGULARISATION, ScalarFunction


def _safe_sqrt(g: Graph, x: int) -> int:
    zero = g.const(0.0)
    held = g.op("max", x, zero)
    root = g.op("sqrt", g.op("add", held, g.const(REGULARISATION)))
    slope = g.op("select", g.op("lt", x, zero), zero, g.op("div", g.const(0.5), root))
    return g.custom(g.op("sqrt", held), [(x, slope)])


def _slope_of_arc(g: Graph, x: int) -> int:
    """1 / sqrt(1 - x^2 + 1e-12) within -1 .. 1, zero outside."""
    one, zero = g.const(1.0), g.const(0.0)
    rest = g.op("max", g.op("sub", one, g.op("mul", x, x)), zero)
    root = g.op("sqrt", g.op("add", rest, g.const(REGULARISATION)))
    outside = g.op("lt", one, g.op("abs", x))
    return g.op("select", outside, zero, g.op("div", one, root))


def _held(g: Graph, x: int) -> int:
    return g.op("min", g.op("max", x, g.const(-1.0)), g.const(1.0))


def _safe_asin(g: Graph, x: int) -> int:
    return g.custom(g.op("asin", _held(g, x)), [(x, _slope_of_arc(g, x))])


def _safe_acos(g: Graph, x: int) -> int:
    slope = g.op("neg", _slope_of_arc(g, x))
    return g.custom(g.op("acos", _held(g, x)), [(x, slope)])


def _safe_atan2(g: Graph, y: int, x: int) -> int:
    squares = g.op("add", g.op("mul", x, x), g.op("mul", y, y))
    reciprocal = g.op("div", g.const(1.0), g.op("add", squares, g.const(REGULARISATION)))
    by_y, by_x = g.op("mul", x, reciprocal), g.op("neg", g.op("mul", y, reciprocal))
    return g.custom(g.op("atan2", y, x), [(y, by_y), (x, by_x)])


FUNCTIONS = (
    ScalarFunction(
        "safe_sqrt",
        1,
        _safe_sqrt,
        "sqrt(max(x, 0))",
        "1 / (2 sqrt(x + 1e-12)) if x >= 0 else 0",
        "0 at 0 with derivative 5e5; 0 with derivative 0 for x < 0",
    ),
    ScalarFunction(
        "safe_asin",
        1,
        _safe_asin,
        "asin(clamp(x, -1, 1))",
        "1 / sqrt(1 - x^2 + 1e-12) if |x| <= 1 else 0",
        "pi/2 at 1, -pi/2 at -1, derivative 1e6 at both; constant with derivative 0 beyond",
    ),
    ScalarFunction(
        "safe_acos",
        1,
        _safe_acos,
        "acos(clamp(x, -1, 1))",
        "-1 / sqrt(1 - x^2 + 1e-12) if |x| <= 1 else 0",
        "0 at 1, pi at -1, derivative -1e6 at both; constant with derivative 0 beyond",
    ),
    ScalarFunction(
        "safe_atan2",
        2,
        _safe_atan2,
        "atan2(x, y)",
        "y / (x^2 + y^2 + 1e-12); -x / (x^2 + y^2 + 1e-12)",
        "0 at (0, 0) with derivatives 0 and 0; derivatives never above 5e5",
    ),
)
