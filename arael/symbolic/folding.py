"""Values of primitive operations on constants.

Folding is done in binary64 with the C library's functions. What has no finite value is never
folded: the operation stays in the graph, so that the NaN or the infinity appears at run time, where
it can be reported with its place.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from arael.runtime.machine.library import FUNCTIONS


def _round_half_away(x: float) -> float:
    return math.copysign(math.floor(abs(x) + 0.5), x)


def _sign(x: float) -> float:
    return float((x > 0) - (x < 0))


_VALUE: dict[str, Callable[..., float]] = {
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "div": lambda a, b: a / b,
    "neg": lambda a: -a,
    **{f.name: f.fold for f in FUNCTIONS},
    "abs": abs,
    "sign": _sign,
    "heaviside": lambda x: 0.5 * (_sign(x) + 1.0),
    "floor": lambda x: float(math.floor(x)),
    "ceil": lambda x: float(math.ceil(x)),
    "round": _round_half_away,
    "min": min,
    "max": max,
    "lt": lambda a, b: float(a < b),
    "le": lambda a, b: float(a <= b),
    "eq": lambda a, b: float(a == b),
    "ne": lambda a, b: float(a != b),
    "and": lambda a, b: float(a != 0 and b != 0),
    "or": lambda a, b: float(a != 0 or b != 0),
    "not": lambda a: float(a == 0),
}


def fold(name: str, *values: float) -> float | None:
    """Value of operation `name` on `values`, or None if it has none that is finite."""
    function = _VALUE.get(name)
    if function is None:
        return None
    try:
        result = float(function(*values))
    except (ValueError, OverflowError, ZeroDivisionError):
        return None
    return result if math.isfinite(result) else None
