"""Units of values, known or unknown.

A scalar has a known unit, an unknown one (data declared without a unit is not checked), or is a
literal number, which takes the unit of the other terms of a sum. A matrix has one of these for all
elements, a vector one for all or one for each.
"""

from __future__ import annotations

from enum import Enum
from fractions import Fraction

from arael.check.units import Unit, angle_power, interchangeable


class Open(Enum):
    """A literal number, which adapts to any unit."""

    NUMBER = "a number"
    UNKNOWN = "not checked"


NUMBER = Open.NUMBER
UNKNOWN = Open.UNKNOWN

Scalar = Unit | Open
Quantity = Scalar | tuple[Scalar, ...]


class Clash(Exception):
    """Two units that meet in a sum and differ."""

    def __init__(self, first: Unit, second: Unit) -> None:
        super().__init__(f"{first} and {second}")
        self.first = first
        self.second = second


def joined(a: Scalar, b: Scalar) -> Scalar:
    """The unit of a sum of values in `a` and `b`; a known unit overrides an unknown one.

    Raises
    ------
    Clash
        If both are units and differ.
    """
    if a is b:
        return a
    if isinstance(a, Unit) and isinstance(b, Unit):
        if not interchangeable(a, b):
            raise Clash(a, b)
        return a if abs(angle_power(a)) <= abs(angle_power(b)) else b
    if isinstance(a, Unit):
        return a
    return b if isinstance(b, Unit) or a is NUMBER else a


def all_joined(quantity: Quantity) -> Scalar:
    """The one unit that all elements have.

    Raises
    ------
    Clash
        If elements differ.
    """
    if not isinstance(quantity, tuple):
        return quantity
    total: Scalar = NUMBER
    for item in quantity:
        total = joined(total, item)
    return total


def times(a: Scalar, b: Scalar) -> Scalar:
    """The unit of a product."""
    if isinstance(a, Unit) and isinstance(b, Unit):
        return a * b
    if a is UNKNOWN or b is UNKNOWN:
        return UNKNOWN
    return b if a is NUMBER else a


def power(a: Scalar, exponent: Fraction | int) -> Scalar:
    """The unit of a power."""
    return a**exponent if isinstance(a, Unit) else a


def spread(quantity: Quantity, size: int) -> tuple[Scalar, ...]:
    """The unit of each of `size` elements."""
    return quantity if isinstance(quantity, tuple) else (quantity,) * size


def packed(items: tuple[Scalar, ...]) -> Quantity:
    """One unit for all of `items` if they are equal."""
    return items[0] if items and all(i is items[0] or i == items[0] for i in items) else items
