"""The units that a model may name, each as a product of base units and prime numbers.

Factors such as 1000 or 60 are kept as powers of primes, so that units form a group in which every
comparison is exact, roots included. `rad` and `deg` are both base units: there is no implicit
conversion. Counts (pixels, ticks) are base units too.
"""

from __future__ import annotations

from fractions import Fraction
from functools import lru_cache
from types import MappingProxyType

Powers = MappingProxyType[str, Fraction]

BASES = ("m", "kg", "s", "A", "K", "mol", "cd", "rad", "deg", "rev", "px", "tick", "bit", "frame")

# Prefixes as powers of ten.
_PREFIXES = {"n": -9, "u": -6, "m": -3, "c": -2, "d": -1, "k": 3, "M": 6, "G": 9}

# Derived units: factor and definition.
_DERIVED: dict[str, tuple[Fraction, dict[str, int]]] = {
    "g": (Fraction(1, 1000), {"kg": 1}),
    "t": (Fraction(1000), {"kg": 1}),
    "Hz": (Fraction(1), {"s": -1}),
    "N": (Fraction(1), {"kg": 1, "m": 1, "s": -2}),
    "J": (Fraction(1), {"kg": 1, "m": 2, "s": -2}),
    "W": (Fraction(1), {"kg": 1, "m": 2, "s": -3}),
    "Pa": (Fraction(1), {"kg": 1, "m": -1, "s": -2}),
    "bar": (Fraction(10**5), {"kg": 1, "m": -1, "s": -2}),
    "V": (Fraction(1), {"kg": 1, "m": 2, "s": -3, "A": -1}),
    "C": (Fraction(1), {"A": 1, "s": 1}),
    "ohm": (Fraction(1), {"kg": 1, "m": 2, "s": -3, "A": -2}),
    "F": (Fraction(1), {"kg": -1, "m": -2, "s": 4, "A": 2}),
    "H": (Fraction(1), {"kg": 1, "m": 2, "s": -2, "A": -2}),
    "Wb": (Fraction(1), {"kg": 1, "m": 2, "s": -2, "A": -1}),
    "T": (Fraction(1), {"kg": 1, "s": -2, "A": -1}),
    "lm": (Fraction(1), {"cd": 1, "rad": 2}),
    "sr": (Fraction(1), {"rad": 2}),
    "min": (Fraction(60), {"s": 1}),
    "h": (Fraction(3600), {"s": 1}),
    "day": (Fraction(86400), {"s": 1}),
    "l": (Fraction(1, 1000), {"m": 3}),
    "ft": (Fraction(3048, 10000), {"m": 1}),
    "inch": (Fraction(254, 10000), {"m": 1}),
    "rpm": (Fraction(1, 60), {"rev": 1, "s": -1}),
    "gon": (Fraction(9, 10), {"deg": 1}),
    "arcmin": (Fraction(1, 60), {"deg": 1}),
    "arcsec": (Fraction(1, 3600), {"deg": 1}),
}

# Other spellings.
_SYNONYMS = {
    "meter": "m", "metre": "m", "meters": "m", "metres": "m", "sec": "s", "second": "s",
    "seconds": "s", "minute": "min", "hour": "h", "gram": "g", "radian": "rad", "radians": "rad",
    "degree": "deg", "degrees": "deg", "pixel": "px", "pixels": "px", "ticks": "tick",
    "count": "tick", "counts": "tick", "pulse": "tick", "pulses": "tick", "frames": "frame",
    "turn": "rev", "hz": "Hz",
}  # fmt: skip

# Units that take a prefix.
_PREFIXED = {
    *("m", "g", "s", "A", "K", "rad", "mol", "px", "bit", "bar", "C", "l"),
    *("Hz", "N", "J", "W", "Pa", "V", "ohm", "F", "H", "T"),
}


@lru_cache(maxsize=1024)
def powers_of(name: str) -> Powers | None:
    """Base units and primes of the unit `name`; None where there is no such unit."""
    name = _SYNONYMS.get(name, name)
    if name in BASES:
        return MappingProxyType({name: Fraction(1)})
    if name in _DERIVED:
        factor, made_of = _DERIVED[name]
        return _joined(_primes(factor), {k: Fraction(v) for k, v in made_of.items()})
    prefix, rest = name[:1], name[1:]
    if prefix in _PREFIXES and rest in _PREFIXED:
        inner = powers_of(rest)
        assert inner is not None
        return _joined(_primes(Fraction(10) ** _PREFIXES[prefix]), dict(inner))
    return None


def short_name(name: str) -> str:
    """The usual spelling of a unit: ``m`` for ``metre``."""
    return _SYNONYMS.get(name, name)


def known_names() -> list[str]:
    """Units without their prefixes, common ones first; for suggestions."""
    return [*BASES, *_DERIVED, "mm", "cm", "km", "ms", "us", "mrad", *_SYNONYMS]


def _primes(factor: Fraction) -> dict[str, Fraction]:
    exponents: dict[str, Fraction] = {}
    for number, sign in ((factor.numerator, 1), (factor.denominator, -1)):
        divisor = 2
        while number > 1:
            while number % divisor == 0:
                number //= divisor
                exponents[str(divisor)] = exponents.get(str(divisor), Fraction(0)) + sign
            divisor += 1
    return exponents


def _joined(a: dict[str, Fraction], b: dict[str, Fraction]) -> Powers:
    total = dict(a)
    for name, power in b.items():
        total[name] = total.get(name, Fraction(0)) + power
    return MappingProxyType({k: v for k, v in total.items() if v})
