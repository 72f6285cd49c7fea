"""Functions of a squared angle that are smooth at zero, where their closed forms are 0/0.

Below a small angle they are summed from their power series, so that values and derivatives are
right there; the closed form is kept away from zero even where its result is not taken.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from arael.symbolic.graph import Graph

# Below this squared angle the series are exact to rounding; above, closed forms lose less than
# that to cancellation.
_SMALL_ANGLE_SQUARED = 0.04

_COSINE = (1.0, -1 / 2, 1 / 24, -1 / 720, 1 / 40320, -1 / 3628800)
_SINC = (1.0, -1 / 6, 1 / 120, -1 / 5040, 1 / 362880, -1 / 39916800)
_HALF_VERSINE = (1 / 2, -1 / 24, 1 / 720, -1 / 40320, 1 / 3628800, -1 / 479001600)
_SINE_REST = (1 / 6, -1 / 120, 1 / 5040, -1 / 362880, 1 / 39916800, -1 / 6227020800)
_COTANGENT_REST = (1 / 12, 1 / 720, 1 / 30240, 1 / 1209600, 1 / 47900160, 691 / 1307674368000)


def polynomial(g: Graph, x: int, coefficients: Sequence[float]) -> int:
    """Polynomial by Horner's rule, lowest coefficient first."""
    result = g.const(coefficients[-1])
    for coefficient in reversed(coefficients[:-1]):
        result = g.op("add", g.const(coefficient), g.op("mul", x, result))
    return result


def _joined(
    g: Graph, t2: int, coefficients: Sequence[float], closed: Callable[[int, int], int]
) -> int:
    """The series where the squared angle `t2` is small, else ``closed(t, t2)``."""
    small = g.op("lt", t2, g.const(_SMALL_ANGLE_SQUARED))
    away = g.op("select", small, g.const(1.0), t2)
    far = closed(g.op("sqrt", away), away)
    return g.op("select", small, polynomial(g, t2, coefficients), far)


def cosine(g: Graph, t2: int) -> int:
    """``cos t``."""
    return _joined(g, t2, _COSINE, lambda t, _: g.op("cos", t))


def sinc(g: Graph, t2: int) -> int:
    """``sin t / t``."""
    return _joined(g, t2, _SINC, lambda t, _: g.op("div", g.op("sin", t), t))


def half_versine(g: Graph, t2: int) -> int:
    """``(1 - cos t) / t^2``."""
    return _joined(
        g,
        t2,
        _HALF_VERSINE,
        lambda t, s: g.op("div", g.op("sub", g.const(1.0), g.op("cos", t)), s),
    )


def sine_rest(g: Graph, t2: int) -> int:
    """``(t - sin t) / t^3``."""
    return _joined(
        g,
        t2,
        _SINE_REST,
        lambda t, s: g.op("div", g.op("sub", t, g.op("sin", t)), g.op("mul", t, s)),
    )


def cotangent_rest(g: Graph, t2: int) -> int:
    """``1/t^2 - cot(t/2) / (2 t)``, for t below 2 pi."""

    def closed(t: int, s: int) -> int:
        half = g.op("mul", g.const(0.5), t)
        ratio = g.op("div", g.op("mul", half, g.op("cos", half)), g.op("sin", half))
        return g.op("div", g.op("sub", g.const(1.0), ratio), s)

    return _joined(g, t2, _COTANGENT_REST, closed)
