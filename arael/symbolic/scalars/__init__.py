"""The scalar functions of the language: those of the table of operations, and constants."""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from types import MappingProxyType

from arael.operations import OPERATIONS
from arael.symbolic.scalars.function import ScalarFunction, constant, scalar_function

SCALARS: Mapping[str, ScalarFunction] = MappingProxyType(
    {
        **{one.name: scalar_function(one) for one in OPERATIONS.values() if one.function},
        "pi": constant("pi", math.pi, "3.14159..."),
        "e": constant("e", math.e, "2.71828..."),
        "epsilon": constant(
            "epsilon", sys.float_info.epsilon, "2^-52, the spacing of binary64 at 1"
        ),
    }
)

__all__ = ["SCALARS", "ScalarFunction"]
