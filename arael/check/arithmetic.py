"""Numbers of constant expressions: defaults, bounds, settings of passes.

Only scalars, and vectors and matrices element by element: what a constant needs. Formulas of the
built-in functions are those of the language reference.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from arael.check.typed import Apply, Component, Literal_, Pack, Select, Typed
from arael.check.types import size_of
from arael.check.walk import postorder

Values = tuple[float, ...]


def _sign(x: float) -> float:
    return (x > 0) - (x < 0)


def _round(x: float) -> float:
    """Halves go away from zero, as C's round()."""
    return math.copysign(math.floor(abs(x) + 0.5), x)


def _heaviside(x: float) -> float:
    return 0.5 if x == 0 else float(x > 0)


def _wrapped(x: float) -> float:
    """An angle in -pi to pi."""
    return math.atan2(math.sin(x), math.cos(x))


def _clamped(x: float) -> float:
    return max(-1.0, min(1.0, x))


SCALARS: dict[str, Callable[..., float]] = {
    "neg": lambda x: -x,
    "add": lambda x, y: x + y,
    "sub": lambda x, y: x - y,
    "emul": lambda x, y: x * y,
    "ediv": lambda x, y: x / y,
    "pow": math.pow,
    "lt": lambda x, y: float(x < y),
    "le": lambda x, y: float(x <= y),
    "gt": lambda x, y: float(x > y),
    "ge": lambda x, y: float(x >= y),
    "eq": lambda x, y: float(x == y),
    "ne": lambda x, y: float(x != y),
    "and": lambda x, y: float(x != 0 and y != 0),
    "or": lambda x, y: float(x != 0 or y != 0),
    "not": lambda x: float(x == 0),
    "sin": math.sin,
    "cos": math.cos,
    "tan": math.tan,
    "asin": math.asin,
    "acos": math.acos,
    "atan": math.atan,
    "atan2": math.atan2,
    "sinh": math.sinh,
    "cosh": math.cosh,
    "tanh": math.tanh,
    "exp": math.exp,
    "log": math.log,
    "log2": math.log2,
    "log10": math.log10,
    "sqrt": math.sqrt,
    "cbrt": math.cbrt,
    "hypot": math.hypot,
    "abs": abs,
    "sign": _sign,
    "min": min,
    "max": max,
    "clamp": lambda x, low, high: max(low, min(high, x)),
    "floor": math.floor,
    "ceil": math.ceil,
    "round": _round,
    "heaviside": _heaviside,
    "identity": lambda x: x,
    "safe_sqrt": lambda x: math.sqrt(max(x, 0.0)),
    "safe_asin": lambda x: math.asin(_clamped(x)),
    "safe_acos": lambda x: math.acos(_clamped(x)),
    "safe_atan2": math.atan2,
    "rad_diff": lambda a, b: _wrapped(a - b),
    "rad_sum": lambda a, b: _wrapped(a + b),
    "deg2rad": math.radians,
    "rad2deg": math.degrees,
    "fast_atan": math.atan,
    "fast_atan2": math.atan2,
    "starship": lambda r, gamma: gamma * math.atan(r / gamma),
    "starship_gamma": lambda d: 2 * math.sqrt(d) / math.pi,
}


class NotConstant(Exception):
    """An expression has no constant value; `node` is to blame, `reason` says why."""

    def __init__(self, node: Typed, reason: str) -> None:
        super().__init__(reason)
        self.node = node
        self.reason = reason


def evaluate(expression: Typed) -> Values:
    """Values of a constant expression, flat (matrices row by row).

    Raises
    ------
    NotConstant
        Where the expression divides by zero, leaves the range of real numbers, or uses an
        operation that constants do not have.
    """
    known: dict[int, Values] = {}
    for node in postorder([expression]):
        known[id(node)] = _value(node, known)
    return known[id(expression)]


def _value(node: Typed, known: dict[int, Values]) -> Values:
    if isinstance(node, Literal_):
        return (node.value,)
    if isinstance(node, Pack):
        return tuple(x for item in node.items for x in known[id(item)])
    if isinstance(node, Component):
        return (known[id(node.of)][node.index],)
    if isinstance(node, Select):
        taken = node.then if known[id(node.cond)][0] != 0 else node.otherwise
        return known[id(taken)]
    if isinstance(node, Apply):
        return _applied(node, [known[id(a)] for a in node.args])
    raise NotConstant(node, "depends on the data")


def _applied(node: Apply, args: Sequence[Values]) -> Values:
    if node.name in ("identity2", "identity3"):
        n = int(node.name[-1])
        return tuple(float(i == j) for i in range(n) for j in range(n))
    name = node.name
    if name in ("mul", "div") and (len(args[0]) == 1 or len(args[1]) == 1):
        name = "e" + name
    function = SCALARS.get(name)
    if function is None or max(map(len, args)) != size_of(node.type):
        raise NotConstant(node, f"`{node.name}` of these operands is not for constants")
    size = size_of(node.type)
    spread = [a if len(a) == size else a * size for a in args]
    try:
        result = tuple(float(function(*x)) for x in zip(*spread, strict=True))
    except ZeroDivisionError:
        raise NotConstant(node, "divides by zero") from None
    except (ValueError, OverflowError):
        raise NotConstant(node, "has no real value") from None
    if not all(map(math.isfinite, result)):
        raise NotConstant(node, "is not finite")
    return result
