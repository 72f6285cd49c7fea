"""The constants of the language: the only place of their values."""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from types import MappingProxyType
from typing import NamedTuple


class Constant(NamedTuple):
    """A named number, and the text for it in tables of functions."""

    number: float
    text: str


CONSTANTS: Mapping[str, Constant] = MappingProxyType(
    {
        "pi": Constant(math.pi, "3.14159..."),
        "e": Constant(math.e, "2.71828..."),
        "epsilon": Constant(sys.float_info.epsilon, "2^-52, the spacing of binary64 at 1"),
    }
)
"""Constants by name."""
