"""How each primitive of a tape is written in Cython.

The forms keep NaN where NumPy keeps it, so that a kernel and the interpreter agree on bad input
too, and use no branches, so that a loop over lanes vectorises. `m_*` names are bound in the module
head to the C library's functions of the module's precision.
"""

from __future__ import annotations

import math

from arael.runtime.machine.library import FUNCTIONS
from arael.runtime.machine.tape import NATIVE

_BINARY = {"add": "{0} + {1}", "sub": "{0} - {1}", "mul": "{0} * {1}", "div": "{0} / {1}"}
_CALLS = [(f.name, f.arity) for f in FUNCTIONS] + [("floor", 1), ("ceil", 1)]
_TEST = {
    "lt": "{0} < {1}",
    "le": "{0} <= {1}",
    "eq": "{0} == {1}",
    "ne": "{0} != {1}",
    "and": "({0} != 0) & ({1} != 0)",
    "or": "({0} != 0) | ({1} != 0)",
    "not": "{0} == 0",
}

FORMS: dict[str, str] = {
    **_BINARY,
    **{name: f"m_{name}({', '.join(['{0}', '{1}'][:arity])})" for name, arity in _CALLS},
    **{name: f"<real>({form})" for name, form in _TEST.items()},
    "neg": "-{0}",
    "abs": "m_abs({0})",
    "identity": "{0}",
    "sign": "({0} if {0} != {0} else <real>({0} > 0) - <real>({0} < 0))",
    "heaviside": "({0} if {0} != {0} else <real>0.5 * (<real>({0} > 0) + <real>({0} >= 0)))",
    "round": "m_copysign(m_floor(m_abs({0}) + <real>0.5), {0})",
    "min": "({0} if ({0} < {1}) | ({0} != {0}) else {1})",
    "max": "({0} if ({0} > {1}) | ({0} != {0}) else {1})",
    "select": "({1} if {0} != 0 else {2})",
}


def literal(value: float) -> str:
    """Write a number exactly, in the module's precision."""
    if math.isnan(value):
        return "m_nan"
    if math.isinf(value):
        return "m_inf" if value > 0 else "(-m_inf)"
    text = repr(float(value))
    return f"<real>{text}" if value >= 0 and text[0] != "-" else f"(<real>{text})"


def expression(op: str, operands: list[str]) -> str:
    """One operation on named operands."""
    if op.startswith(NATIVE):
        number = f"native_{op.removeprefix(NATIVE)}"
        arguments = ", ".join([f"&lanes.natives[{number}]", *operands])
        return f"<real>call_{len(operands)}({arguments})"
    return FORMS[op].format(*operands)
