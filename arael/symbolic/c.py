"""Expressions in C99, for double or float.

NaN goes through every operation as it does through the expression machine's, also through ``min``,
``max``, ``sign`` and ``heaviside``. Comparisons give 1 and 0 of the floating type.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Sequence

from arael.operations import OPERATIONS, Operation
from arael.symbolic.graph import Graph

REAL_TYPES = {"double": "", "float": "f"}
"""C type of a real, and what the names of its library functions and its literals end with."""

_ATOM = 100
_NEGATION = 7

_PRIMITIVES = {one.name: one for one in OPERATIONS.values() if one.primitive}
_INLINE = {n: one for n, one in _PRIMITIVES.items() if one.c_expression.count("{0}") > 1}
"""Operations that read an operand more than once: functions of `c_prelude`."""


def _expression(one: Operation, operands: Sequence[str], real: str) -> str:
    text = one.c
    for word, literal in (("ONE", "1.0"), ("ZERO", "0.0"), ("HALF", "0.5")):
        text = text.replace(word, literal + REAL_TYPES[real])
    return text.format(*operands)


def c_operation(name: str, operands: Sequence[tuple[str, int]], real: str) -> tuple[str, int]:
    """Write an operation of texts with their bindings: how strongly each holds together."""
    one = _PRIMITIVES[name]
    if one.library or name in _INLINE:
        called = one.library + REAL_TYPES[real] if one.library else f"arael_{name}"
        return f"{called}({', '.join(text for text, _ in operands)})", _ATOM
    grouped = one.c.startswith("(")
    least = (6,) * one.arity if grouped else one.operands
    texts = [t if has >= need else f"({t})" for (t, has), need in zip(operands, least, strict=True)]
    return _expression(one, texts, real), _ATOM if grouped else one.binding


def c_literal(value: float, real: str = "double") -> str:
    """Write a number; what is not finite by the macros of ``math.h``."""
    if math.isnan(value):
        return "NAN"
    if math.isinf(value):
        return "INFINITY" if value > 0 else "-INFINITY"
    return repr(float(value)) + REAL_TYPES[real]


def c_prelude(real: str = "double") -> str:
    """Define the functions that `c` uses beyond those of ``math.h``."""
    lines = ["#include <math.h>"]
    for name, one in _INLINE.items():
        head = f"arael_{name}({', '.join(f'{real} {operand}' for operand in 'ab'[: one.arity])})"
        value = _expression(one, "ab"[: one.arity], real)
        lines.append(f"static inline {real} {head} {{ return {value}; }}")
    return "\n".join(lines) + "\n"


def c(g: Graph, node: int, names: Callable[[Hashable], str] = str, real: str = "double") -> str:
    """Write `node` as one C expression, nothing shared; it may call functions of `c_prelude`."""
    written: dict[int, tuple[str, int]] = {}
    for current in g.live([node]):
        name = g.ops[current]
        value = g.value(current)
        if value is not None:
            text = c_literal(value, real)
            written[current] = text, _NEGATION if text.startswith("-") else _ATOM
        elif name == "input":
            written[current] = names(g.key(current)), _ATOM
        elif g.is_free(current):
            written[current] = written[g.args[current][0]]
        elif name in g.functions:
            arguments = ", ".join(written[a][0] for a in g.args[current])
            written[current] = f"{g.functions[name].name}({arguments})", _ATOM
        else:
            written[current] = c_operation(name, [written[a] for a in g.args[current]], real)
    return written[node][0]
