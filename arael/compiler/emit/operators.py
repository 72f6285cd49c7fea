"""How each primitive of a tape is written in Cython.

The forms keep NaN where NumPy keeps it, so that kernels and machine agree on bad input
too, and use no branches, so that a loop over lanes vectorises. `m_*` names are bound in the module
head to the C library's functions of the module's precision.
"""

from __future__ import annotations

import math

from arael.operations import OPERATIONS
from arael.runtime.machine.tape import NATIVE

FORMS: dict[str, str] = {
    one.name: one.kernel_expression for one in OPERATIONS.values() if one.primitive
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
