"""Expressions in Python, over scalars or NumPy arrays, with NumPy imported as ``np``.

What NumPy lacks is called as ``scipy.special.erf``.
"""

from __future__ import annotations

import math

from arael.operations import OPERATIONS, Operation
from arael.symbolic.graph import Graph
from arael.symbolic.printers.infix import Form, Names, Notation, default_name, write


def _literal(value: float) -> str:
    if math.isfinite(value):
        return repr(value)
    return "np.nan" if math.isnan(value) else "-np.inf" if value < 0 else "np.inf"


def _form(one: Operation) -> Form:
    template = one.python_expression
    if "(" in template:
        return Form(template, operands=(2,) * one.arity if " " in template else (0,) * one.arity)
    # Powers bind to the right, which the language leaves to parentheses.
    return Form(template, one.binding, (11, 10) if one.name == "pow" else one.operands)


PYTHON = Notation(
    {one.name: _form(one) for one in OPERATIONS.values() if one.primitive}, _literal, 7
)


def python(g: Graph, node: int, names: Names = default_name) -> str:
    """Write `node` as a Python expression."""
    return write(g, node, PYTHON, names)
