"""Scales of parameters, from the units that the formula gives them.

``exp(-b * x)`` makes b the inverse of x, ``a + b * x = y`` makes b a y per x. Each column has a
unit of its own; sums of unlike units, and arguments of transcendental functions with a unit, are
not allowed. That is a linear system for the exponents of the parameters' units (Bridgman,
"Dimensional analysis", 1922), solved by least squares: a formula may contradict itself or leave
exponents open, which then are zero. The same powers of the columns' magnitudes are the scales.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import Source
from arael.syntax import tree
from arael.syntax.parser import parse_expression

Array = NDArray[np.float64]
Exponents = dict[str, float]
"""Of a unit: exponent by the name of a column or a parameter."""

_KEEP = frozenset({"abs", "min", "max", "floor", "ceil", "round", "hypot", "mod"})
"""Functions whose value has the unit of their arguments."""


def exponents(
    formula: str, predicts: str | None, parameters: tuple[str, ...], columns: tuple[str, ...]
) -> Array:
    """Exponents (parameters, columns) of the units of the parameters.

    Parameters
    ----------
    formula : its text
    predicts : the column whose unit the formula has
    """
    found = _Units(frozenset((*parameters, *columns)))
    unit = found.unit(parse_expression(Source("formula", formula)))
    if predicts is not None:
        found.equal(unit, {predicts: 1.0})
    rows = [row for row in found.equations if any(row.get(p) for p in parameters)]
    if not rows:
        return np.zeros((len(parameters), len(columns)))
    left = np.array([[row.get(p, 0.0) for p in parameters] for row in rows])
    right = -np.array([[row.get(c, 0.0) for c in columns] for row in rows])
    solved = np.linalg.lstsq(left, right, rcond=1e-10)[0]
    return np.asarray(np.round(2 * solved) / 2)


@dataclass
class _Units:
    """Equations between units of the parts of a formula: each a sum of exponents that is zero."""

    known: frozenset[str]
    equations: list[Exponents] = field(default_factory=list)

    def equal(self, a: Exponents | None, b: Exponents | None) -> None:
        if a is not None and b is not None:
            self.equations.append(_sum(a, b, -1.0))

    def unit(self, node: tree.Expr) -> Exponents | None:
        """The unit of an expression; None: any."""
        if isinstance(node, tree.Number):
            return {} if float(node.text) else None
        if isinstance(node, tree.Name):
            return {node.id: 1.0} if node.id in self.known else {}
        if isinstance(node, tree.Unary):
            return self.unit(node.operand)
        if isinstance(node, tree.Binary):
            return self._binary(node)
        if isinstance(node, tree.Call):
            return self._call(node)
        if isinstance(node, tree.Conditional):
            then, otherwise = self.unit(node.then), self.unit(node.otherwise)
            self.unit(node.cond)
            self.equal(then, otherwise)
            return then
        return None

    def _binary(self, node: tree.Binary) -> Exponents | None:
        left, right = self.unit(node.left), self.unit(node.right)
        if node.op == "^":
            self.equal(right, {})
            power = _number(node.right)
            if left is None or power is None:
                return None
            return {name: power * exponent for name, exponent in left.items()}
        if node.op in ("*", ".*", "/", "./"):
            if left is None or right is None:
                return None
            return _sum(left, right, -1.0 if "/" in node.op else 1.0)
        self.equal(left, right)
        return right if left is None else left

    def _call(self, node: tree.Call) -> Exponents | None:
        name = node.func.id if isinstance(node.func, tree.Name) else ""
        units = [self.unit(argument) for argument in node.args]
        if name == "sqrt" and units[0] is not None:
            return {symbol: exponent / 2 for symbol, exponent in units[0].items()}
        if name in _KEEP:
            for other in units[1:]:
                self.equal(units[0], other)
            return units[0] if units else None
        if name == "atan2":
            self.equal(units[0], units[-1])
        elif name != "pow":
            for one in units:
                self.equal(one, {})
        return {}


def _sum(a: Exponents, b: Exponents, factor: float) -> Exponents:
    found = dict(a)
    for name, exponent in b.items():
        found[name] = found.get(name, 0.0) + factor * exponent
    return found


def _number(node: tree.Expr) -> float | None:
    """The value of a number with or without a sign or a quotient of two."""
    if isinstance(node, tree.Number):
        return float(node.text)
    if isinstance(node, tree.Unary) and node.op == "-":
        inner = _number(node.operand)
        return None if inner is None else -inner
    if isinstance(node, tree.Binary) and node.op == "/":
        a, b = _number(node.left), _number(node.right)
        return a / b if a is not None and b else None
    return None


def magnitude(unit: Array, columns: Mapping[str, Array]) -> float:
    """The unit's powers of the columns' largest magnitudes."""
    scale = 1.0
    for exponent, column in zip(unit, columns.values(), strict=True):
        largest = float(np.abs(column).max(initial=0.0))
        if exponent and largest > 0:
            scale *= largest**exponent
    return scale


def quantiles(
    unit: Array, columns: Mapping[str, Array], low: float, high: float
) -> Callable[[Array], Array]:
    """Candidate values of a parameter as a function of numbers between 0 and 1.

    A parameter with the unit of one column is a place in it (half of the candidates, spread evenly
    over its range) or a width. All others are of either sign, one in five negative, and spread
    evenly in their logarithm over six decades about their scale.

    Parameters
    ----------
    unit : exponents of its unit, by column
    columns : the data
    low, high : bounds of the parameter
    """
    scale = magnitude(unit, columns)
    place = [
        column for exponent, column in zip(unit, columns.values(), strict=True) if exponent == 1.0
    ]
    decades = 3.0 if unit.any() else 2.0
    if len(place) == 1 and np.count_nonzero(unit) == 1:
        least, most = float(place[0].min()), float(place[0].max())
    else:
        least = most = 0.0

    def values(u: Array) -> Array:
        if np.isfinite(low) and np.isfinite(high) and high > low:
            return low + (high - low) * u
        share = 0.5 if most > least else 0.0
        at_place = least + (most - least) * u / max(share, 1e-9)
        v = (u - share) / (1 - share)
        if share:
            spread = (most - least) * 10 ** (3 * (v - 1) + 0.5)
        else:
            negative = v < 0.2
            v = np.where(negative, v / 0.2, (v - 0.2) / 0.8)
            spread = np.where(negative, -1, 1) * scale * 10 ** (decades * (2 * v - 1))
            if low >= 0:
                spread = np.abs(spread)
            elif high <= 0:
                spread = -np.abs(spread)
        found: Array = np.clip(np.where(u < share, at_place, spread), low, high)
        return found

    return values
