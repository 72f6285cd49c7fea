"""Units as a commutative group: products of named units with rational powers.

Two units are equal if they are the same product of base units and numbers: ``N`` equals
``kg*m/s^2``, ``mm`` does not equal ``m``. Names are stored, so that messages show the units as
written. All functions are pure.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from fractions import Fraction

from arael.check.units_table import powers_of

Factors = tuple[tuple[str, Fraction], ...]


class Unit:
    """A product of named units.

    Attributes
    ----------
    factors : names with their powers, in order of appearance
    base : the same as a product of base units and primes, sorted; equality and hash go by it
    """

    __slots__ = ("base", "factors")

    def __init__(self, factors: Iterable[tuple[str, Fraction]] = ()) -> None:
        total: dict[str, Fraction] = {}
        for name, power in factors:
            total[name] = total.get(name, Fraction(0)) + power
        base: dict[str, Fraction] = {}
        for name, power in total.items():
            for part, inner in (powers_of(name) or {name: Fraction(1)}).items():
                base[part] = base.get(part, Fraction(0)) + inner * power
        self.base: Factors = tuple(sorted((k, v) for k, v in base.items() if v))
        named = tuple((k, v) for k, v in total.items() if v)
        self.factors: Factors = named if self.base else ()

    @property
    def is_one(self) -> bool:
        """Whether this is the unit of pure numbers."""
        return not self.base

    def __mul__(self, other: Unit) -> Unit:
        if not other.factors:
            return self
        return Unit((*self.factors, *other.factors)) if self.factors else other

    def __truediv__(self, other: Unit) -> Unit:
        return self * other ** Fraction(-1)

    def __pow__(self, power: Fraction | int) -> Unit:
        return self if power == 1 else Unit((name, p * power) for name, p in self.factors)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Unit) and self.base == other.base

    def __hash__(self) -> int:
        return hash(self.base)

    def __repr__(self) -> str:
        return f"Unit({self})"

    def __str__(self) -> str:
        above = [_power(n, p) for n, p in self.factors if p > 0]
        below = [_power(n, -p) for n, p in self.factors if p < 0]
        top = "*".join(above) or "1"
        if not below:
            return top
        bottom = "*".join(below)
        return f"{top}/({bottom})" if len(below) > 1 else f"{top}/{bottom}"

    def dimensions(self) -> Mapping[str, Fraction]:
        """Powers of the base units, without factors such as 1000."""
        return {name: power for name, power in self.base if not name.isdigit()}

    @property
    def factor(self) -> float:
        """The numeric factor of this unit: 0.001 for ``mm``, 1 for ``m``."""
        primes = ((float(name), float(power)) for name, power in self.base if name.isdigit())
        return math.prod(math.pow(prime, power) for prime, power in primes)


def _power(name: str, power: Fraction) -> str:
    if power == 1:
        return name
    return f"{name}^{power}" if power.denominator == 1 else f"{name}^({power})"


ONE = Unit()
RAD = Unit([("rad", Fraction(1))])
DEG = Unit([("deg", Fraction(1))])


def interchangeable(a: Unit, b: Unit) -> bool:
    """Whether values in `a` and `b` may be added.

    They are equal; or they differ in powers of radians only and contain another unit, as in ``v =
    cross(omega, r)``, where (rad/s) m is m/s.
    """
    if a.base == b.base:
        return True
    rest = [[(n, p) for n, p in unit.base if n != "rad"] for unit in (a, b)]
    return rest[0] == rest[1] and any(not n.isdigit() for n, _ in rest[0])


def angle_power(unit: Unit) -> Fraction:
    """Power of radians in `unit`."""
    return dict(unit.base).get("rad", Fraction(0))
