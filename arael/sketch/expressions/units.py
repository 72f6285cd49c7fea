"""Units that may follow a literal in a sketch."""

from __future__ import annotations

import math
from types import MappingProxyType
from typing import NamedTuple


class Unit(NamedTuple):
    """A unit.

    Attributes
    ----------
    quantity : ``length`` or ``angle``
    size : in millimetres, or in degrees
    """

    quantity: str
    size: float


UNITS = MappingProxyType(
    {
        "um": Unit("length", 1e-3),
        "mm": Unit("length", 1.0),
        "cm": Unit("length", 10.0),
        "m": Unit("length", 1000.0),
        "inch": Unit("length", 25.4),
        "ft": Unit("length", 304.8),
        "deg": Unit("angle", 1.0),
        "rad": Unit("angle", 180.0 / math.pi),
    }
)

#: As units are written in sketches; `in` is a reserved word of formulas.
SPELLED = MappingProxyType({("in" if name == "inch" else name): name for name in UNITS})


def factor(unit: str, document_unit: str) -> float:
    """What one of a unit is in a sketch's unit of length, or in degrees."""
    found = UNITS[SPELLED[unit]]
    if found.quantity == "angle":
        return found.size
    return found.size / UNITS[SPELLED[document_unit]].size
