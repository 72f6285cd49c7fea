"""Units of the expressions of one body, inferred as they are typed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from arael.check.declared import FieldDecl
from arael.check.typed import (
    QUATERNION,
    Apply,
    Component,
    Formula,
    Literal_,
    LookUp,
    MatrixType,
    Pack,
    Read,
    Select,
    Total,
    TransformType,
    Typed,
)
from arael.check.types import size_of
from arael.check.units import ONE, RAD
from arael.check.units_quantities import (
    UNKNOWN,
    Clash,
    Quantity,
    Scalar,
    all_joined,
    joined,
    packed,
    power,
    spread,
    times,
)
from arael.check.units_rules import Misfit, result_of


@dataclass
class Units:
    """Unit of each expression; typed expressions are equal only to themselves."""

    fields: dict[Typed, FieldDecl] = field(default_factory=dict)
    known: dict[Typed, Quantity] = field(default_factory=dict)

    def read(self, node: Typed, field: FieldDecl | None) -> None:
        """Record that `node` reads `field`; called before the node is added."""
        if field is not None:
            self.fields[node] = field

    def look_up(self, node: LookUp, value: Quantity, key: Quantity) -> None:
        """Record the unit of a look-up: that of its column, by that of the key for a rate."""
        if not node.derivative:
            self.known[node] = value
            return
        over = power(all_joined(key), -node.derivative)
        if node.value == QUATERNION:
            self.known[node] = times(RAD, over)
            return
        size = size_of(node.type)
        self.known[node] = packed(tuple(times(one, over) for one in spread(value, size)))

    def of(self, node: Typed) -> Quantity:
        """The unit of an expression that was added before."""
        unit = self.known.get(node)
        if unit is not None:
            return unit
        if isinstance(node, Pack):  # a constant
            return _pack(self, node)
        return node.unit if isinstance(node, Literal_) else UNKNOWN

    def note(self, node: Typed) -> Clash | Misfit | None:
        """Infer the unit of `node` from its operands; return how they do not fit."""
        rule = _RULES.get(type(node))
        if rule is None:
            return None
        try:
            unit = rule(self, node)
        except (Clash, Misfit) as error:
            return error
        if unit is not UNKNOWN:
            self.known[node] = unit
        return None


def _read(units: Units, node: Read) -> Quantity:
    declared = units.fields.get(node)
    return declared.quantity if declared is not None else UNKNOWN


def _component(units: Units, node: Component) -> Quantity:
    whole = units.of(node.of)
    if isinstance(node.of.type, TransformType) and node.index >= 3:
        return ONE
    return whole[node.index] if isinstance(whole, tuple) else whole


def _pack(units: Units, node: Pack) -> Quantity:
    items: list[Scalar] = []
    for item in node.items:
        size = size_of(item.type)
        items += spread(units.of(item), size)
    if not isinstance(node.type, MatrixType):
        return packed(tuple(items))
    try:  # a matrix has one unit
        return UNKNOWN if UNKNOWN in items else all_joined(tuple(items))
    except Clash:
        return UNKNOWN


def _select(units: Units, node: Select) -> Quantity:
    a, b = units.of(node.then), units.of(node.otherwise)
    if isinstance(a, tuple) or isinstance(b, tuple):
        size = size_of(node.type)
        return packed(tuple(map(joined, spread(a, size), spread(b, size))))
    return joined(a, b)


def _apply(units: Units, node: Apply) -> Quantity:
    return result_of(node, [units.of(a) for a in node.args])


_RULES: dict[type, Callable[[Units, Any], Quantity]] = {
    Read: _read,
    Component: _component,
    Formula: lambda units, node: units.of(node.of),
    Total: lambda units, node: units.of(node.of),
    Pack: _pack,
    Select: _select,
    Apply: _apply,
}
