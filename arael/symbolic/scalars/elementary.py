"""Elementary functions: IEEE arithmetic at their singular points, nothing is hidden there."""

from __future__ import annotations

import math
import sys

from arael.symbolic.graph import Graph
from arael.symbolic.scalars.function import ScalarFunction, primitive


def _constant(name: str, number: float, value: str) -> ScalarFunction:
    def build(g: Graph) -> int:
        return g.const(number)

    return ScalarFunction(name, 0, build, value, "0")


def _scaled(name: str, factor: float, value: str) -> ScalarFunction:
    def build(g: Graph, x: int) -> int:
        return g.op("mul", g.const(factor), x)

    return ScalarFunction(name, 1, build, value, repr(factor))


FUNCTIONS = (
    primitive("sin", 1, "cos(x)"),
    primitive("cos", 1, "-sin(x)"),
    primitive("tan", 1, "1 + tan(x)^2"),
    primitive("asin", 1, "1 / sqrt(1 - x^2)", "NaN for |x| > 1; derivative inf at x = -1, 1"),
    primitive("acos", 1, "-1 / sqrt(1 - x^2)", "NaN for |x| > 1; derivative -inf at x = -1, 1"),
    primitive("atan", 1, "1 / (1 + x^2)"),
    primitive(
        "atan2",
        2,
        "y / (x^2 + y^2); -x / (x^2 + y^2)",
        "0 at (0, 0) with derivative NaN; jumps across the negative half axis of y",
        "angle of the vector (y, x): atan2(x, y) has the sine's side first",
    ),
    primitive("sinh", 1, "cosh(x)"),
    primitive("cosh", 1, "sinh(x)"),
    primitive("tanh", 1, "1 - tanh(x)^2"),
    primitive("exp", 1, "exp(x)"),
    primitive("log", 1, "1 / x", "-inf at 0 with derivative inf; NaN for x < 0", "ln(x)"),
    primitive("log2", 1, "1 / (x ln 2)", "-inf at 0 with derivative inf; NaN for x < 0"),
    primitive("log10", 1, "1 / (x ln 10)", "-inf at 0 with derivative inf; NaN for x < 0"),
    primitive("sqrt", 1, "1 / (2 sqrt(x))", "0 at 0 with derivative inf; NaN for x < 0"),
    primitive("cbrt", 1, "1 / (3 cbrt(x)^2)", "0 at 0 with derivative inf"),
    primitive(
        "hypot",
        2,
        "x / hypot(x, y); y / hypot(x, y)",
        "0 at (0, 0) with derivative NaN",
        "sqrt(x^2 + y^2) without overflow",
    ),
    primitive(
        "pow",
        2,
        "y x^(y - 1); x^y ln(x)",
        "x^0 = 1, also at 0, with derivative NaN by x there; at x = 0 the derivative by y is 0; "
        "NaN for x < 0 unless y is an integer",
        "x^y",
    ),
    primitive("identity", 1, "1", value="x; simplification does not look through it"),
    _constant("pi", math.pi, "3.14159..."),
    _constant("e", math.e, "2.71828..."),
    _constant("epsilon", sys.float_info.epsilon, "2^-52, the spacing of binary64 at 1"),
    _scaled("deg2rad", math.pi / 180, "pi / 180 x"),
    _scaled("rad2deg", 180 / math.pi, "180 / pi x"),
)
