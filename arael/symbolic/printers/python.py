"""Expressions in Python, over scalars or NumPy arrays, with NumPy imported as ``np``.

What NumPy lacks is called as ``scipy.special.erf``.
"""

from __future__ import annotations

import math

from arael.runtime.machine.library import FUNCTIONS
from arael.runtime.machine.tape import PRIMITIVES
from arael.symbolic.graph import Graph
from arael.symbolic.printers.infix import Form, Names, Notation, call, default_name, write


def _literal(value: float) -> str:
    if math.isfinite(value):
        return repr(value)
    return "np.nan" if math.isnan(value) else "-np.inf" if value < 0 else "np.inf"


def _as_number(condition: str) -> Form:
    return Form(f"np.where({condition}, 1.0, 0.0)", operands=(2, 2))


_NAMES = {
    **{f.name: f.python for f in FUNCTIONS if f.name != "pow"},
    **{name: f"np.{name}" for name in ("floor", "ceil", "abs", "sign")},
    "min": "np.minimum",
    "max": "np.maximum",
    "select": "np.where",
}

PYTHON = Notation(
    {
        "add": Form("{0} + {1}", 6, (6, 7)),
        "sub": Form("{0} - {1}", 6, (6, 7)),
        "mul": Form("{0} * {1}", 8, (7, 9)),
        "div": Form("{0} / {1}", 8, (7, 9)),
        "neg": Form("-{0}", 7, (8,)),
        "pow": Form("{0} ** {1}", 10, (11, 10)),
        "identity": Form("+{0}", 7, (8,)),
        "heaviside": Form("np.heaviside({0}, 0.5)"),
        "round": Form("np.copysign(np.floor(np.abs({0}) + 0.5), {0})"),
        "lt": _as_number("{0} < {1}"),
        "le": _as_number("{0} <= {1}"),
        "eq": _as_number("{0} == {1}"),
        "ne": _as_number("{0} != {1}"),
        "and": _as_number("({0} != 0) & ({1} != 0)"),
        "or": _as_number("({0} != 0) | ({1} != 0)"),
        "not": _as_number("{0} == 0"),
        **{name: call(to, PRIMITIVES[name][0]) for name, to in _NAMES.items()},
    },
    _literal,
    7,
)


def python(g: Graph, node: int, names: Names = default_name) -> str:
    """Write `node` as a Python expression."""
    return write(g, node, PYTHON, names)
