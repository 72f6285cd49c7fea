"""The text of a unit: ``m``, ``1/rad``, ``m/s^2``, ``rad/(s*sqrt(Hz))``."""

from __future__ import annotations

import re
from fractions import Fraction
from functools import lru_cache

from arael.check.units import ONE, Unit
from arael.check.units_table import powers_of

MAX_POWER = 20
MAX_PARENTHESES = 8
_TOKEN = re.compile(r"[A-Za-z_]\w*|[0-9]+(?:\.[0-9]+)?|[*/^()-]")


class BadUnit(Exception):
    """A text that is not a unit; `name` is the unknown name, if that is the reason."""

    def __init__(self, reason: str, name: str = "") -> None:
        super().__init__(reason)
        self.reason = reason
        self.name = name


@lru_cache(maxsize=1024)
def parse_unit(text: str) -> Unit:
    """Parse `text` as a unit.

    Raises
    ------
    BadUnit
        Where a name is unknown, or the text is not a product of units.
    """
    reader = _Reader(_TOKEN.findall(text.replace(" ", "")))
    unit = reader.product()
    if reader.tokens:
        raise BadUnit(f"`{reader.tokens[0]}` is not expected in a unit")
    return unit


class _Reader:
    """Reads a product of powers, left to right."""

    def __init__(self, tokens: list[str]) -> None:
        self.tokens = tokens
        self.open = 0

    def product(self) -> Unit:
        """Read ``a * b / c``."""
        unit = self._factor()
        while self.tokens and self.tokens[0] in "*/":
            by = self.tokens.pop(0)
            factor = self._factor()
            unit = unit * factor if by == "*" else unit / factor
        return unit

    def _factor(self) -> Unit:
        unit = self._atom()
        if self.tokens and self.tokens[0] == "^":
            self.tokens.pop(0)
            unit = unit ** self._exponent()
        return unit

    def _atom(self) -> Unit:
        token = self._next()
        if token == "(" or (self.tokens[:1] == ["("] and token == "sqrt"):
            if token == "sqrt":
                self.tokens.pop(0)
            unit = self._within()
            return unit ** Fraction(1, 2) if token == "sqrt" else unit
        if token[0].isdigit():
            if Fraction(token) != 1:
                raise BadUnit(f"a unit has no factors such as {token}: write `mm`, `km`, `ms`")
            return ONE
        if powers_of(token) is None:
            raise BadUnit("", token)
        return Unit([(token, Fraction(1))])

    def _within(self) -> Unit:
        self.open += 1
        if self.open > MAX_PARENTHESES:
            raise BadUnit(f"more than {MAX_PARENTHESES} parentheses within each other")
        unit = self.product()
        self._close()
        return unit

    def _close(self) -> None:
        if self._next() != ")":
            raise BadUnit("a parenthesis is not closed")
        self.open -= 1

    def _exponent(self) -> Fraction:
        token = self._next()
        if token == "-":
            return -self._exponent()
        if token == "(":
            above = self._exponent()
            if self.tokens[:1] == ["/"]:
                self.tokens.pop(0)
                below = self._exponent()
                if below == 0:
                    raise BadUnit("a power divided by zero")
                above /= below
            self._close_power()
            return above
        if not token[0].isdigit() or len(token) > 9 or Fraction(token) > MAX_POWER:
            raise BadUnit(f"`{token[:20]}` is not a power: write a number up to {MAX_POWER}")
        return Fraction(token)

    def _close_power(self) -> None:
        if self._next() != ")":
            raise BadUnit("a power is a number: `^2`, `^-1`, `^(1/2)`")

    def _next(self) -> str:
        if not self.tokens:
            raise BadUnit("the unit ends too early")
        return self.tokens.pop(0)
