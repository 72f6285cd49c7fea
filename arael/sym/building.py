"""Making expressions as they are written.

What was written is kept, order included; only literal numbers are worked out (``2 * 3``, not
``1 / 3``), and what adds nothing vanishes: ``x + 0``, ``1 * x``, ``x ^ 1``, ``--x``. A factor 0
gives 0, as in models.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from arael.sym.expr import Expr, const
from arael.symbolic.folding import fold

_LARGEST_EXACT = 2.0**53


def build(op: str, *args: Expr) -> Expr:
    """Make operation `op` of `args`."""
    rule = _RULES.get(op)
    found = rule(*args) if rule is not None else None
    return Expr(op, args) if found is None else found


def _folded(op: str, a: Expr, b: Expr) -> Expr | None:
    if a.op != "const" or b.op != "const":
        return None
    value = fold(op, a.data, b.data)
    return None if value is None else const(value)


def _minus(x: Expr) -> Expr | None:
    """Return what `x` is the opposite of, where that shows."""
    if x.op == "neg":
        return x.args[0]
    return const(-x.data) if x.op == "const" and x.data < 0 else None


def _add(a: Expr, b: Expr) -> Expr | None:
    if (found := _folded("add", a, b)) is not None:
        return found
    if a.value == 0:
        return b
    if b.value == 0:
        return a
    opposite = _minus(b)
    return None if opposite is None else build("sub", a, opposite)


def _sub(a: Expr, b: Expr) -> Expr | None:
    if (found := _folded("sub", a, b)) is not None:
        return found
    if b.value == 0:
        return a
    if a.value == 0:
        return build("neg", b)
    opposite = _minus(b)
    return None if opposite is None else build("add", a, opposite)


def _mul(a: Expr, b: Expr) -> Expr | None:
    if (found := _folded("mul", a, b)) is not None:
        return found
    for x, y in ((a, b), (b, a)):
        if x.value == 0:
            return x
        if x.value == 1:
            return y
        if x.value == -1:
            return build("neg", y)
    return None


def _div(a: Expr, b: Expr) -> Expr | None:
    if b.value == 1:
        return a
    if a.value is None or b.value is None:
        return None
    whole = a.data.is_integer() and b.data.is_integer()
    if whole and (b.data == 0 or math.fmod(a.data, b.data) != 0):
        return None  # 1 / 3 reads better than 0.3333333333333333
    return _folded("div", a, b)


def _pow(a: Expr, b: Expr) -> Expr | None:
    if b.value == 1:
        return a
    if b.value == 0:
        return const(1.0)
    found = _folded("pow", a, b)
    if found is None or not found.data.is_integer() or abs(found.data) >= _LARGEST_EXACT:
        return None  # 2 ^ 0.5 reads better than 1.4142135623730951
    return found


def _neg(a: Expr) -> Expr | None:
    if a.op == "const":
        return const(-a.data)
    return a.args[0] if a.op == "neg" else None


def _select(condition: Expr, then: Expr, otherwise: Expr) -> Expr | None:
    if condition.op == "const":
        return then if condition.data != 0 else otherwise
    return None


_RULES: dict[str, Callable[..., Expr | None]] = {
    "add": _add,
    "sub": _sub,
    "mul": _mul,
    "div": _div,
    "pow": _pow,
    "neg": _neg,
    "select": _select,
}
