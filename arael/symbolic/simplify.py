"""Smart constructors: one small rule set per operation, applied when a node is made.

Rules are local: they look at the operands of the new node and at whether an equivalent node exists
already. Sums and products are not reassociated, so rounding is that of the formula as written,
except that signed zeros are not kept and that zero times anything is zero: without that rule a
sparse derivative would be a dense one (a NaN that only multiplies a structural zero is thereby
lost).

Signs float outwards: ``(-a) * b`` becomes ``-(a * b)``, so that ``a * b`` is shared, and ``a - b``
and ``b - a`` are one node and its negation. A negative constant counts as the negation of a
positive one.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

from arael.operations import OPERATIONS
from arael.operations.numbers import value as value_on_numbers

if TYPE_CHECKING:
    from arael.symbolic.graph import Graph

Rule = Callable[..., int]

_ODD = [one.name for one in OPERATIONS.values() if one.parity == "odd"]
_EVEN = [one.name for one in OPERATIONS.values() if one.parity == "even"]
_BOOLEAN = frozenset({"lt", "le", "eq", "ne", "and", "or", "not"})
_LARGEST_POWER = 8


def fold(name: str, *values: float) -> float | None:
    """Value of operation `name` on constants, in binary64; None if it has none that is finite.

    The operation then stays in the graph, so that the NaN or the infinity appears at run time,
    where it can be reported with its place.
    """
    result = value_on_numbers(name, *values)
    return result if math.isfinite(result) else None


def _negated(g: Graph, node: int) -> int | None:
    """Return the node whose negation `node` is, if it is one."""
    if g.ops[node] == "neg":
        return g.args[node][0]
    value = g.value(node)
    return g.const(-value) if value is not None and value < 0 else None


def _is_power_of_two(value: float) -> bool:
    return math.isfinite(value) and math.frexp(value)[0] in (0.5, -0.5)


def _ordered(a: int, b: int) -> tuple[int, int]:
    return (a, b) if a <= b else (b, a)


def _add(g: Graph, a: int, b: int) -> int:
    if 0 in (g.value(a), g.value(b)):
        return b if g.value(a) == 0 else a
    minus_a, minus_b = _negated(g, a), _negated(g, b)
    if minus_a is not None and minus_b is not None:
        return g.op("neg", g.op("add", minus_a, minus_b))
    if minus_b is not None:
        return g.op("sub", a, minus_b)
    if minus_a is not None:
        return g.op("sub", b, minus_a)
    if a == b:
        return g.op("mul", g.const(2.0), a)
    return g.intern("add", _ordered(a, b))


def _sub(g: Graph, a: int, b: int) -> int:
    if a == b:
        return g.const(0.0)
    if g.value(b) == 0:
        return a
    if g.value(a) == 0:
        return g.op("neg", b)
    minus_a, minus_b = _negated(g, a), _negated(g, b)
    if minus_a is not None and minus_b is not None:
        return g.op("sub", minus_b, minus_a)
    if minus_b is not None:
        return g.op("add", a, minus_b)
    if minus_a is not None:
        return g.op("neg", g.op("add", minus_a, b))
    if g.exists("sub", (b, a)):
        return g.op("neg", g.intern("sub", (b, a)))
    return g.intern("sub", (a, b))


def _neg(g: Graph, a: int) -> int:
    return g.args[a][0] if g.ops[a] == "neg" else g.intern("neg", (a,))


def _signs_out(g: Graph, name: str, a: int, b: int) -> int | None:
    """A product or quotient of negations without them, and its sign; None if there are none."""
    minus_a, minus_b = _negated(g, a), _negated(g, b)
    if minus_a is None and minus_b is None:
        return None
    found = g.op(name, a if minus_a is None else minus_a, b if minus_b is None else minus_b)
    return g.op("neg", found) if (minus_a is None) != (minus_b is None) else found


def _mul(g: Graph, a: int, b: int) -> int:
    if g.value(a) is None:
        a, b = b, a
    factor = g.value(a)  # a constant comes first, if there is one
    if factor in (0, 1):
        return b if factor else a
    positive = _signs_out(g, "mul", a, b)
    if positive is not None:
        return positive
    if factor is not None and g.ops[b] == "mul":
        for number, rest in (g.args[b], g.args[b][::-1]):
            inner = g.value(number)
            exact = inner is not None and (_is_power_of_two(factor) or _is_power_of_two(inner))
            if inner is not None and exact and 1e-300 < abs(factor * inner) < math.inf:
                return g.op("mul", g.const(factor * inner), rest)
    return g.intern("mul", _ordered(a, b))


def _div(g: Graph, a: int, b: int) -> int:
    divisor = g.value(b)
    if divisor == 0:
        return g.intern("div", (a, b))
    if divisor == 1 or g.value(a) == 0:
        return a
    positive = _signs_out(g, "div", a, b)
    if positive is not None:
        return positive
    if divisor is not None and _is_power_of_two(divisor) and math.isfinite(1.0 / divisor):
        return g.op("mul", g.const(1.0 / divisor), a)
    return g.intern("div", (a, b))


def _integer_power(g: Graph, base: int, exponent: int) -> int:
    """Product by repeated squaring; `exponent` is at least 1."""
    if exponent == 1:
        return base
    half = _integer_power(g, base, exponent // 2)
    square = g.op("mul", half, half)
    return g.op("mul", square, base) if exponent % 2 else square


def _pow(g: Graph, base: int, exponent: int) -> int:
    power = g.value(exponent)
    if power is not None:
        if power == 0:
            return g.const(1.0)
        raised = None
        if abs(power) == 0.5:
            raised = g.op("sqrt", base)
        elif abs(power) <= _LARGEST_POWER and power == int(power):
            raised = _integer_power(g, base, abs(int(power)))
        if raised is not None:
            return raised if power > 0 else g.op("div", g.const(1.0), raised)
    return base if g.value(base) == 1 else g.intern("pow", (base, exponent))


def _identity(g: Graph, a: int) -> int:
    return a if g.ops[a] == "identity" else g.intern("identity", (a,))


def _hypot(g: Graph, a: int, b: int) -> int:
    if 0 in (g.value(a), g.value(b)):
        return g.op("abs", b if g.value(a) == 0 else a)
    positive = (n if (p := _negated(g, n)) is None else p for n in (a, b))
    return g.intern("hypot", _ordered(*positive))


def _junction(name: str, deciding: bool) -> Rule:
    """``and``, which a false operand decides, or ``or``, which a true one does."""

    def rule(g: Graph, a: int, b: int) -> int:
        for this, other in ((a, b), (b, a)):
            value = g.value(this)
            if value is not None and (value != 0) == deciding:
                return g.const(float(deciding))
            if (value is not None or this == other) and g.ops[other] in _BOOLEAN:
                return other
        return g.intern(name, _ordered(a, b))

    return rule


def _not(g: Graph, a: int) -> int:
    if g.ops[a] == "not" and g.ops[g.args[a][0]] in _BOOLEAN:
        return g.args[a][0]
    return g.intern("not", (a,))


def _select(g: Graph, condition: int, taken: int, otherwise: int) -> int:
    decided = g.value(condition)
    if decided is not None or taken == otherwise:
        return otherwise if decided == 0 else taken
    if g.ops[condition] == "not":
        return g.op("select", g.args[condition][0], otherwise, taken)
    if g.ops[taken] == "neg" and g.ops[otherwise] == "neg":
        arms = g.args[taken][0], g.args[otherwise][0]
        return g.op("neg", g.op("select", condition, *arms))
    return g.intern("select", (condition, taken, otherwise))


def _odd(name: str) -> Rule:
    def rule(g: Graph, a: int, *others: int) -> int:
        if g.ops[a] == "neg":
            return g.op("neg", g.op(name, g.args[a][0], *others))
        return g.intern(name, (a, *others))

    return rule


def _even(name: str) -> Rule:
    def rule(g: Graph, a: int) -> int:
        if g.ops[a] == "neg" or (name == "abs" and g.ops[a] == "abs"):
            return g.op(name, g.args[a][0])
        return g.intern(name, (a,))

    return rule


def _of_equals(name: str, value: Callable[[Graph, int], int]) -> Rule:
    """A rule that knows the value for equal operands."""
    return lambda g, a, b: value(g, a) if a == b else g.intern(name, (a, b))


def _commutative(name: str) -> Rule:
    return lambda g, a, b: g.intern(name, _ordered(a, b))


RULES: dict[str, Rule] = {
    "add": _add,
    "sub": _sub,
    "mul": _mul,
    "div": _div,
    "neg": _neg,
    "pow": _pow,
    "identity": _identity,
    "hypot": _hypot,
    "atan2": _odd("atan2"),
    "lt": _of_equals("lt", lambda g, a: g.const(0.0)),
    "and": _junction("and", False),
    "or": _junction("or", True),
    "not": _not,
    "select": _select,
    **{name: _odd(name) for name in _ODD},
    **{name: _even(name) for name in _EVEN},
    **{name: _of_equals(name, lambda g, a: a) for name in ("min", "max")},
    **{name: _commutative(name) for name in ("eq", "ne")},
}
