"""Functions of a squared angle that are smooth at zero, where their closed forms are 0/0.

Below a small angle they are summed from their power series, so that values and derivatives are
right there; the closed form is kept away from zero even where its result is not taken.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from arael.symbolic.graph import Graph
from arael.symbolic.operators import Scalar

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
    g: Graph, t2: int, coefficients: Sequence[float], closed: Callable[[Scalar, Scalar], Scalar]
) -> int:
    """The series where the squared angle `t2` is small, else ``closed(t, t2)``."""
    small = Scalar(g, t2) < _SMALL_ANGLE_SQUARED
    away = small.select(1.0, Scalar(g, t2))
    far = closed(away.sqrt(), away)
    return g.op("select", small.node, polynomial(g, t2, coefficients), far.node)


def cosine(g: Graph, t2: int) -> int:
    """``cos t``."""
    return _joined(g, t2, _COSINE, lambda t, s: t.cos())


def sinc(g: Graph, t2: int) -> int:
    """``sin t / t``."""
    return _joined(g, t2, _SINC, lambda t, s: t.sin() / t)


def half_versine(g: Graph, t2: int) -> int:
    """``(1 - cos t) / t^2``."""
    return _joined(g, t2, _HALF_VERSINE, lambda t, s: (1.0 - t.cos()) / s)


def sine_rest(g: Graph, t2: int) -> int:
    """``(t - sin t) / t^3``."""
    return _joined(g, t2, _SINE_REST, lambda t, s: (t - t.sin()) / (t * s))


def cotangent_rest(g: Graph, t2: int) -> int:
    """``1/t^2 - cot(t/2) / (2 t)``, for t below 2 pi."""

    def closed(t: Scalar, s: Scalar) -> Scalar:
        half = 0.5 * t
        return (1.0 - half * half.cos() / half.sin()) / s

    return _joined(g, t2, _COTANGENT_REST, closed)
