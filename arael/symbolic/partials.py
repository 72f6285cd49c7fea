"""Partial derivatives of the primitive operations, as nodes of the graph.

`partials` gives, for a node, each operand through which it varies and the partial derivative with
respect to it. What is missing is structurally zero: comparisons, ``floor ceil round sign
heaviside``.

Singular points of the plain functions follow IEEE arithmetic: the derivative of ``sqrt`` and
``log`` at 0 and of ``asin`` and ``acos`` at 1 is infinite, that of ``atan2`` and ``hypot`` at the
origin NaN. ``abs`` has 0 at 0; ``min`` and ``max`` take the first argument at a tie.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from arael.symbolic.graph import Graph

Partials = list[tuple[int, int]]
Rule = Callable[..., Partials]


def _one_over(g: Graph, node: int) -> int:
    return g.op("div", g.const(1.0), node)


def _square(g: Graph, node: int) -> int:
    return g.op("mul", node, node)


def _add(g: Graph, node: int, a: int, b: int) -> Partials:
    return [(a, g.const(1.0)), (b, g.const(1.0))]


def _sub(g: Graph, node: int, a: int, b: int) -> Partials:
    return [(a, g.const(1.0)), (b, g.const(-1.0))]


def _mul(g: Graph, node: int, a: int, b: int) -> Partials:
    if a == b:
        return [(a, g.op("mul", g.const(2.0), a))]
    return [(a, b), (b, a)]


def _div(g: Graph, node: int, a: int, b: int) -> Partials:
    reciprocal = _one_over(g, b)
    return [(a, reciprocal), (b, g.op("neg", g.op("mul", node, reciprocal)))]


def _pow(g: Graph, node: int, base: int, exponent: int) -> Partials:
    """Make the partial by the exponent 0 at base 0: the limit of x^y log x for y > 0."""
    lower = g.op("pow", base, g.op("sub", exponent, g.const(1.0)))
    result = [(base, g.op("mul", exponent, lower))]
    if g.value(exponent) is None:
        at_zero = g.op("eq", base, g.const(0.0))
        logarithm = g.op("log", g.op("select", at_zero, g.const(1.0), base))
        result.append((exponent, g.op("mul", node, logarithm)))
    return result


def _sqrt(g: Graph, node: int, a: int) -> Partials:
    return [(a, g.op("div", g.const(0.5), node))]


def _cbrt(g: Graph, node: int, a: int) -> Partials:
    return [(a, _one_over(g, g.op("mul", g.const(3.0), _square(g, node))))]


def _log(base: float) -> Rule:
    scale = 1.0 / math.log(base)
    return lambda g, node, a: [(a, g.op("div", g.const(scale), a))]


def _arc(sign: float) -> Rule:
    """Of asin and acos."""

    def rule(g: Graph, node: int, a: int) -> Partials:
        root = g.op("sqrt", g.op("sub", g.const(1.0), _square(g, a)))
        return [(a, g.op("div", g.const(sign), root))]

    return rule


def _atan(g: Graph, node: int, a: int) -> Partials:
    return [(a, _one_over(g, g.op("add", g.const(1.0), _square(g, a))))]


def _atan2(g: Graph, node: int, y: int, x: int) -> Partials:
    reciprocal = _one_over(g, g.op("add", _square(g, x), _square(g, y)))
    return [(y, g.op("mul", x, reciprocal)), (x, g.op("neg", g.op("mul", y, reciprocal)))]


def _hypot(g: Graph, node: int, a: int, b: int) -> Partials:
    reciprocal = _one_over(g, node)
    return [(a, g.op("mul", a, reciprocal)), (b, g.op("mul", b, reciprocal))]


RULES: dict[str, Rule] = {
    "add": _add,
    "sub": _sub,
    "neg": lambda g, node, a: [(a, g.const(-1.0))],
    "identity": lambda g, node, a: [(a, g.const(1.0))],
    "mul": _mul,
    "div": _div,
    "pow": _pow,
    "sqrt": _sqrt,
    "cbrt": _cbrt,
    "exp": lambda g, node, a: [(a, node)],
    "log": lambda g, node, a: [(a, _one_over(g, a))],
    "log2": _log(2.0),
    "log10": _log(10.0),
    "sin": lambda g, node, a: [(a, g.op("cos", a))],
    "cos": lambda g, node, a: [(a, g.op("neg", g.op("sin", a)))],
    "tan": lambda g, node, a: [(a, g.op("add", g.const(1.0), _square(g, node)))],
    "asin": _arc(1.0),
    "acos": _arc(-1.0),
    "atan": _atan,
    "atan2": _atan2,
    "sinh": lambda g, node, a: [(a, g.op("cosh", a))],
    "cosh": lambda g, node, a: [(a, g.op("sinh", a))],
    "tanh": lambda g, node, a: [(a, g.op("sub", g.const(1.0), _square(g, node)))],
    "hypot": _hypot,
    "abs": lambda g, node, a: [(a, g.op("sign", a))],
}

# Constant wherever they have a derivative: it is zero, also where they jump.
FLAT = frozenset(
    {"sign", "heaviside", "floor", "ceil", "round", "lt", "le", "eq", "ne", "and", "or", "not"}
)


def arguments(g: Graph, node: int) -> tuple[int, ...]:
    """Nodes through which `node` varies, so far as its operation tells."""
    name = g.ops[node]
    if name in ("input", "const") or name in FLAT:
        return ()
    if name == "custom":
        return g.args[node][1::2]
    if name in g.functions:
        return g.functions[name].arguments(g.args[node])
    return g.args[node][1:] if name == "select" else g.args[node]


def branches(g: Graph, node: int) -> tuple[int, int, int] | None:
    """Condition and arms of a node that takes one of two values: ``select``, ``min``, ``max``.

    Their derivative is that of the arm taken, and nothing of the other may leak into it, not even
    multiplied by zero: it may be infinite or NaN.
    """
    name, args = g.ops[node], g.args[node]
    if name == "select":
        return args[0], args[1], args[2]
    if name == "min":
        return g.op("le", args[0], args[1]), args[0], args[1]
    if name == "max":
        return g.op("le", args[1], args[0]), args[0], args[1]
    return None


def partials(g: Graph, node: int) -> Partials:
    """Pairs of an operand and the partial derivative of `node` with respect to it.

    Not for nodes that `branches` answers for.
    """
    name = g.ops[node]
    if name == "custom":
        flat = g.args[node][1:]
        return list(zip(flat[::2], flat[1::2], strict=True))
    if name in g.functions:
        function = g.functions[name]
        given = function.arguments(g.args[node])
        return list(zip(given, function.partials(g, given), strict=True))
    return RULES[name](g, node, *g.args[node])
