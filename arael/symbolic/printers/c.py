"""Expressions in C99, for double or float.

NaN goes through every operation as it does through the interpreter's, also through ``min``,
``max``, ``sign`` and ``heaviside``. Comparisons give 1 and 0 of the floating type.
"""

from __future__ import annotations

import math
from functools import cache

from arael.runtime.machine.library import FUNCTIONS
from arael.runtime.machine.tape import PRIMITIVES
from arael.symbolic.graph import Graph
from arael.symbolic.printers.infix import Form, Names, Notation, call, default_name, write

REAL_TYPES = {"double": "", "float": "f"}
"""C type of a real, and what the names of its library functions and its literals end with."""

_LIBRARY = {
    **{f.name: f.c_name for f in FUNCTIONS},
    **{name: name for name in ("floor", "ceil", "round")},
    "abs": "fabs",
}

# Operands occur more than once in these; ONE, ZERO and HALF stand for literals.
_INLINE = {
    "sign": "({0} > ZERO ? ONE : {0} < ZERO ? -ONE : {0})",
    "heaviside": "({0} > ZERO ? ONE : {0} < ZERO ? ZERO : {0} == ZERO ? HALF : {0})",
    "min": "({0} < {1} || {0} != {0} ? {0} : {1})",
    "max": "({0} > {1} || {0} != {0} ? {0} : {1})",
}
_SIMPLE = {
    "add": Form("{0} + {1}", 6, (6, 7)),
    "sub": Form("{0} - {1}", 6, (6, 7)),
    "mul": Form("{0} * {1}", 8, (7, 9)),
    "div": Form("{0} / {1}", 8, (7, 9)),
    "neg": Form("-{0}", 7, (8,)),
    "identity": Form("{0}", 7, (8,)),
    "lt": Form("({0} < {1} ? ONE : ZERO)", operands=(6, 6)),
    "le": Form("({0} <= {1} ? ONE : ZERO)", operands=(6, 6)),
    "eq": Form("({0} == {1} ? ONE : ZERO)", operands=(6, 6)),
    "ne": Form("({0} != {1} ? ONE : ZERO)", operands=(6, 6)),
    "and": Form("({0} != ZERO && {1} != ZERO ? ONE : ZERO)", operands=(6, 6)),
    "or": Form("({0} != ZERO || {1} != ZERO ? ONE : ZERO)", operands=(6, 6)),
    "not": Form("({0} == ZERO ? ONE : ZERO)", operands=(6,)),
    "select": Form("({0} != ZERO ? {1} : {2})", operands=(6, 6, 6)),
}


def c_literal(value: float, real: str = "double") -> str:
    """Write a number; what is not finite by the macros of ``math.h``."""
    if math.isnan(value):
        return "NAN"
    if math.isinf(value):
        return "INFINITY" if value > 0 else "-INFINITY"
    return repr(float(value)) + REAL_TYPES[real]


@cache
def _forms(real: str) -> dict[str, Form]:
    literals = {"ONE": "1.0", "ZERO": "0.0", "HALF": "0.5"}
    forms = dict(_SIMPLE)
    forms |= {n: call(f + REAL_TYPES[real], PRIMITIVES[n][0]) for n, f in _LIBRARY.items()}
    forms |= {name: Form(template) for name, template in _INLINE.items()}
    for name, form in forms.items():
        template = form.template
        for word, literal in literals.items():
            template = template.replace(word, literal + REAL_TYPES[real])
        forms[name] = Form(template, form.binding, form.operands)
    return forms


def c_operation(name: str, *operands: str, real: str = "double") -> str:
    """Write one operation of names or literals; for printing a program statement by statement."""
    return _forms(real)[name].template.format(*operands)


def c_prelude(real: str = "double") -> str:
    """Define the functions that `c` uses beyond those of ``math.h``."""
    lines = ["#include <math.h>"]
    for name in _INLINE:
        operands = ("a", "b")[: PRIMITIVES[name][0]]
        parameters = ", ".join(f"{real} {operand}" for operand in operands)
        body = c_operation(name, *operands, real=real)
        lines.append(f"static inline {real} arael_{name}({parameters}) {{ return {body}; }}")
    return "\n".join(lines) + "\n"


@cache
def _notation(real: str) -> Notation:
    forms = dict(_forms(real))
    forms |= {name: call(f"arael_{name}", PRIMITIVES[name][0]) for name in _INLINE}
    return Notation(forms, lambda value: c_literal(value, real), 7)


def c(g: Graph, node: int, names: Names = default_name, real: str = "double") -> str:
    """Write `node` as one C expression; it may call functions of `c_prelude`."""
    return write(g, node, _notation(real), names)
