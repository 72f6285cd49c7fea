"""Values of operations on numbers, in binary64 with the C library's functions, without a compiler.

Constants of models are worked out with them: by folding in formulas, and for defaults and settings.
"""

from __future__ import annotations

import numpy as np

from arael.operations.table import OPERATIONS


def value(name: str, *operands: float) -> float:
    """Value of operation `name` on numbers: infinite or NaN as IEEE arithmetic has it."""
    one = OPERATIONS[name]
    try:
        return one.on_numbers(*operands)
    except (ValueError, OverflowError, ZeroDivisionError):
        assert one.numpy is not None
        with np.errstate(all="ignore"):
            return float(one.numpy(*map(np.float64, operands)))


def outside_domain(name: str, *operands: float) -> str:
    """Reason why an operation has no value there: the operands it takes; "" where it has one."""
    one = OPERATIONS.get(name)
    if one is None or one.domain is None or not one.outside(*operands):
        return ""
    return f"`{name}` takes {one.domain.text}"
