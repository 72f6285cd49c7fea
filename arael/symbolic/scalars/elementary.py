"""Elementary functions: IEEE arithmetic at their singular points, nothing is hidden there."""

from __future__ import annotations

import math
import sys

from arael.runtime.machine.library import FUNCTIONS as LIBRARY
from arael.symbolic import series
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


def _sinc(g: Graph, x: int) -> int:
    return series.sinc(g, g.op("mul", x, x))


# Bernoulli numbers B_2k / 2k, k = 1 .. 6: Abramowitz and Stegun, Handbook, 6.3.18.
_BERNOULLI = (1 / 12, -1 / 120, 1 / 252, -1 / 240, 1 / 132, -691 / 32760)
_SHIFT = 10


def _digamma(g: Graph, x: int) -> int:
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


FUNCTIONS = (
    *(primitive(f.name, f.arity, f.derivative, f.singular, f.value) for f in LIBRARY),
    ScalarFunction(
        "sinc",
        1,
        _sinc,
        "sin(x) / x",
        "(cos(x) - sinc(x)) / x",
        "1 at 0 with derivative 0",
    ),
    ScalarFunction(
        "digamma",
        1,
        _digamma,
        "derivative of lgamma(x)",
        "by that of its series",
        "-inf at 0; of size 1e15 at -1, -2, ...",
    ),
    primitive("identity", 1, "1", value="x; simplification does not look through it"),
    _constant("pi", math.pi, "3.14159..."),
    _constant("e", math.e, "2.71828..."),
    _constant("epsilon", sys.float_info.epsilon, "2^-52, the spacing of binary64 at 1"),
    _scaled("deg2rad", math.pi / 180, "pi / 180 x"),
    _scaled("rad2deg", 180 / math.pi, "180 / pi x"),
)
