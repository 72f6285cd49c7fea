"""Expressions in C99, for double or float.

NaN goes through every operation as it does through the interpreter's, also through ``min``,
``max``, ``sign`` and ``heaviside``. Comparisons give 1 and 0 of the floating type.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable
from dataclasses import dataclass
from functools import cache

from arael.runtime.machine.library import FUNCTIONS
from arael.runtime.machine.tape import PRIMITIVES
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
    "add": _Form("{0} + {1}", 6, (6, 7)),
    "sub": _Form("{0} - {1}", 6, (6, 7)),
    "mul": _Form("{0} * {1}", 8, (7, 9)),
    "div": _Form("{0} / {1}", 8, (7, 9)),
    "neg": _Form("-{0}", 7, (8,)),
    "identity": _Form("{0}", 7, (8,)),
    "lt": _Form("({0} < {1} ? ONE : ZERO)", operands=(6, 6)),
    "le": _Form("({0} <= {1} ? ONE : ZERO)", operands=(6, 6)),
    "eq": _Form("({0} == {1} ? ONE : ZERO)", operands=(6, 6)),
    "ne": _Form("({0} != {1} ? ONE : ZERO)", operands=(6, 6)),
    "and": _Form("({0} != ZERO && {1} != ZERO ? ONE : ZERO)", operands=(6, 6)),
    "or": _Form("({0} != ZERO || {1} != ZERO ? ONE : ZERO)", operands=(6, 6)),
    "not": _Form("({0} == ZERO ? ONE : ZERO)", operands=(6,)),
    "select": _Form("({0} != ZERO ? {1} : {2})", operands=(6, 6, 6)),
}


def c_literal(value: float, real: str = "double") -> str:
    """Write a number; what is not finite by the macros of ``math.h``."""
    if math.isnan(value):
        return "NAN"
    if math.isinf(value):
        return "INFINITY" if value > 0 else "-INFINITY"
    return repr(float(value)) + REAL_TYPES[real]


@cache
def _forms(real: str) -> dict[str, _Form]:
    literals = {"ONE": "1.0", "ZERO": "0.0", "HALF": "0.5"}
    forms = dict(_SIMPLE)
    forms |= {n: _call(f + REAL_TYPES[real], PRIMITIVES[n][0]) for n, f in _LIBRARY.items()}
    forms |= {name: _Form(template) for name, template in _INLINE.items()}
    for name, form in forms.items():
        template = form.template
        for word, literal in literals.items():
            template = template.replace(word, literal + REAL_TYPES[real])
        forms[name] = _Form(template, form.binding, form.operands)
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
def _with_functions(real: str) -> dict[str, _Form]:
    inline = {name: _call(f"arael_{name}", PRIMITIVES[name][0]) for name in _INLINE}
    return _forms(real) | inline


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
