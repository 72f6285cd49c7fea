"""Expressions in C99, for double or float.

NaN goes through every operation as it does through the expression machine's, also through ``min``,
``max``, ``sign`` and ``heaviside``. Comparisons give 1 and 0 of the floating type.
"""

from __future__ import annotations

import math
from functools import cache

from arael.operations import OPERATIONS, Operation
from arael.symbolic.graph import Graph
from arael.symbolic.printers.infix import Form, Names, Notation, call, default_name, write

REAL_TYPES = {"double": "", "float": "f"}
"""C type of a real, and what the names of its library functions and its literals end with."""

_PRIMITIVES = {one.name: one for one in OPERATIONS.values() if one.primitive}

# Operands occur more than once in these.
_INLINE = [one for one in _PRIMITIVES.values() if one.c_expression.count("{0}") > 1]
_LITERALS = {"ONE": "1.0", "ZERO": "0.0", "HALF": "0.5"}


def _form(one: Operation, real: str) -> Form:
    if one.library:
        return call(one.library + REAL_TYPES[real], one.arity)
    template = one.c
    for word, literal in _LITERALS.items():
        template = template.replace(word, literal + REAL_TYPES[real])
    if template.startswith("("):
        return Form(template, operands=(0 if one in _INLINE else 6,) * one.arity)
    return Form(template, one.binding, one.operands)


def c_literal(value: float, real: str = "double") -> str:
    """Write a number; what is not finite by the macros of ``math.h``."""
    if math.isnan(value):
        return "NAN"
    if math.isinf(value):
        return "INFINITY" if value > 0 else "-INFINITY"
    return repr(float(value)) + REAL_TYPES[real]


@cache
def _forms(real: str) -> dict[str, Form]:
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
def _notation(real: str) -> Notation:
    forms = dict(_forms(real))
    forms |= {one.name: call(f"arael_{one.name}", one.arity) for one in _INLINE}
    return Notation(forms, lambda value: c_literal(value, real), 7)


def c(g: Graph, node: int, names: Names = default_name, real: str = "double") -> str:
    """Write `node` as one C expression; it may call functions of `c_prelude`."""
    return write(g, node, _notation(real), names)
