"""Functions of the language that are composed of operations: `FORMULAS` by name.

The elementary ones follow IEEE arithmetic at their singular points. The ``safe_`` ones are finite
in value and derivative everywhere: outside their domain they are constant, which hides the
singularity from the solver; a constraint that avoids it is better.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from arael.symbolic import series
from arael.symbolic.operators import Scalar

# Minimax fit of atan(x)/x - 1 in powers of x^2 on 0 .. 1 (Lawson's reweighting); largest error of
# atan 5.03e-8. The leading 1 keeps value and slope exact at 0.
_FAST_ATAN = (
    *(1.0, -0.33331659, 0.19962704, -0.139765819),
    *(0.0979423402, -0.0577735816, 0.0230401298, -0.00435540399),
)

# Bernoulli numbers B_2k / 2k, k = 1 .. 6: Abramowitz and Stegun, Handbook, 6.3.18.
_BERNOULLI = (1 / 12, -1 / 120, 1 / 252, -1 / 240, 1 / 132, -691 / 32760)
_SHIFT = 10


def wrap(angle: Scalar) -> Scalar:
    """`angle` less the whole turns that bring it into (-pi, pi]; slope 1."""
    turn = 2 * math.pi
    return angle - turn * ((angle - math.pi) / turn).ceil()


def _polynomial(x: Scalar, coefficients: tuple[float, ...]) -> Scalar:
    return Scalar(x.graph, series.polynomial(x.graph, x.node, coefficients))


def _fast_atan_unit(x: Scalar) -> Scalar:
    """Evaluate the polynomial, for |x| <= 1."""
    return x * _polynomial(x * x, _FAST_ATAN)


def _fast_atan(x: Scalar) -> Scalar:
    """Arc tangent by the polynomial, of x or of its reciprocal."""
    steep = x.abs() > 1.0
    inner = _fast_atan_unit(steep.select(1.0 / steep.select(x, 1.0), x))
    return steep.select(math.pi / 2 * x.sign() - inner, inner)


def _fast_atan2(y: Scalar, x: Scalar) -> Scalar:
    """Angle of the vector (x, y) by the polynomial."""
    across, along = y.abs(), x.abs()
    larger = across.max(along)
    angle = _fast_atan_unit(across.min(along) / larger.eq(0.0).select(1.0, larger))
    angle = (along < across).select(math.pi / 2 - angle, angle)
    angle = (x < 0.0).select(math.pi - angle, angle)
    return (y < 0.0).select(-angle, angle)


def _digamma(x: Scalar) -> Scalar:
    """Take the asymptotic series beyond 10, recurrence below it, reflection below 0."""
    negative = x < 0.0
    y = negative.select(1.0 - x, x)
    reciprocal = 1.0 / (y + _SHIFT)
    rest = reciprocal * reciprocal
    value = (y + _SHIFT).log() - 0.5 * reciprocal - rest * _polynomial(rest, _BERNOULLI)
    for k in range(_SHIFT):
        value = value - 1.0 / (y + k)
    reflected = value - math.pi / negative.select(math.pi * x, 1.0).tan()
    return negative.select(reflected, value)


FORMULAS: Mapping[str, Callable[..., Scalar]] = {
    "deg2rad": lambda x: math.pi / 180 * x,
    "rad2deg": lambda x: 180 / math.pi * x,
    "rad_diff": lambda x, y: wrap(x - y),
    "rad_sum": lambda x, y: wrap(x + y),
    "fast_atan": _fast_atan,
    "fast_atan2": _fast_atan2,
    "sinc": lambda x: Scalar(x.graph, series.sinc(x.graph, (x * x).node)),
    "digamma": _digamma,
    "clamp": lambda x, low, high: x.max(low).min(high),
    "safe_sqrt": lambda x: x.max(0.0).sqrt(),
    "safe_asin": lambda x: x.max(-1.0).min(1.0).asin(),
    "safe_acos": lambda x: x.max(-1.0).min(1.0).acos(),
    "safe_atan2": lambda y, x: y.atan2(x),
    # gamma atan(r / gamma) is near r for small r and never exceeds gamma pi / 2, so no single
    # residual costs more than (gamma pi / 2)^2. Its authors describe the method as patented
    # (US 12,346,118).
    "starship": lambda r, gamma: gamma * (r / gamma).atan(),
    "starship_gamma": lambda bound: 2 / math.pi * bound.sqrt(),
}
