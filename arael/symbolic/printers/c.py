"""Expressions in C99, for double or float.

NaN goes through every operation as it does through the expression machine's, also through ``min``,
``max``, ``sign`` and ``heaviside``. Comparisons give 1 and 0 of the floating type.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable
from dataclasses import dataclass
from functools import cache

from arael.operations import OPERATIONS, Operation
from arael.symbolic.graph import Graph

LARGEST_TREE = 20_000
"""Operations in the written-out expression above which printing is refused."""

Names = Callable[[Hashable], str]

REAL_TYPES = {"double": "", "float": "f"}
"""C type of a real, and what the names of its library functions and its literals end with."""

_ATOM = 100
_NEGATION = 7


@dataclass(frozen=True)
class _Form:
    """How an operation is written.

    Attributes
    ----------
    template : with ``{0}``, ``{1}`` ... for the operands
    binding : how strongly the whole binds
    operands : per operand, how strongly it must bind to stand without parentheses
    """

    template: str
    binding: int = _ATOM
    operands: tuple[int, ...] = (0, 0, 0)


def _call(name: str, arity: int) -> _Form:
    return _Form(f"{name}({', '.join(f'{{{i}}}' for i in range(arity))})")


_PRIMITIVES = {one.name: one for one in OPERATIONS.values() if one.primitive}

# Operands occur more than once in these.
_INLINE = [one for one in _PRIMITIVES.values() if one.c_expression.count("{0}") > 1]
_LITERALS = {"ONE": "1.0", "ZERO": "0.0", "HALF": "0.5"}


def _form(one: Operation, real: str) -> _Form:
    if one.library:
        return _call(one.library + REAL_TYPES[real], one.arity)
    template = one.c
    for word, literal in _LITERALS.items():
        template = template.replace(word, literal + REAL_TYPES[real])
    if template.startswith("("):
        return _Form(template, operands=(0 if one in _INLINE else 6,) * one.arity)
    return _Form(template, one.binding, one.operands)


def c_literal(value: float, real: str = "double") -> str:
    """Write a number; what is not finite by the macros of ``math.h``."""
    if math.isnan(value):
        return "NAN"
    if math.isinf(value):
        return "INFINITY" if value > 0 else "-INFINITY"
    return repr(float(value)) + REAL_TYPES[real]


@cache
def _forms(real: str) -> dict[str, _Form]:
    return {name: _form(one, real) for name, one in _PRIMITIVES.items()}


def c_operation(name: str, *operands: str, real: str = "double") -> str:
    """Write one operation of names or literals; for printing a program statement by statement."""
    return _forms(real)[name].template.format(*operands)


def c_prelude(real: str = "double") -> str:
    """Define the functions that `c` uses beyond those of ``math.h``."""
    lines = ["#include <math.h>"]
    for one in _INLINE:
        operands = ("a", "b")[: one.arity]
        parameters = ", ".join(f"{real} {operand}" for operand in operands)
        body = c_operation(one.name, *operands, real=real)
        lines.append(f"static inline {real} arael_{one.name}({parameters}) {{ return {body}; }}")
    return "\n".join(lines) + "\n"


@cache
def _with_functions(real: str) -> dict[str, _Form]:
    return _forms(real) | {one.name: _call(f"arael_{one.name}", one.arity) for one in _INLINE}


def default_name(key: Hashable) -> str:
    """Name an input by its key: tuples are joined by underscores."""
    return "_".join(map(str, key)) if isinstance(key, tuple) else str(key)


def c(g: Graph, node: int, names: Names = default_name, real: str = "double") -> str:
    """Write `node` as one C expression; it may call functions of `c_prelude`.

    Raises
    ------
    ValueError
        If that takes more than `LARGEST_TREE` operations.
    """
    size = g.tree_operations([node])
    if size > LARGEST_TREE:
        raise ValueError(
            f"the expression has {size} operations written out, more than {LARGEST_TREE}"
        )
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
            form = _with_functions(real)[name]
            operands = [
                text if binding >= needed else f"({text})"
                for (text, binding), needed in zip(
                    (written[a] for a in g.args[current]), form.operands, strict=False
                )
            ]
            written[current] = form.template.format(*operands), form.binding
    return written[node][0]
