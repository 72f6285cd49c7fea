"""What names of a document mean in its expressions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from arael.diagnostics.suggest import closest
from arael.sketch.document.document import Document
from arael.sketch.document.handles import point_offsets, split_handle
from arael.sketch.document.kinds import DIMENSIONS
from arael.sketch.document.records import Dimension, Entity
from arael.sketch.expressions.evaluation import NoValueError, Value, compiled
from arael.sketch.expressions.functions import CONSTANTS
from arael.sketch.expressions.properties import ANGLES, property_names, property_of
from arael.sketch.expressions.shapes import curve_of
from arael.sketch.expressions.vectors import Vec

Measure = Callable[[Dimension], float]


_MOST_PARAMETERS = 100
"""Parameters that are followed for the unit of one; each may be within the other."""


class DocumentScope:
    """Parameters, dimensions, constants and properties of entities.

    Parameters
    ----------
    measure : value of a dimension that is derived or a range; without it the last value is read
    """

    def __init__(self, document: Document, measure: Measure | None = None) -> None:
        self.document = document
        self.measure = measure

    @property
    def unit(self) -> str:
        """Unit of lengths."""
        return self.document.unit

    def value(self, path: str) -> Value:
        """Value of a name; raises `NoValueError` if it has none."""
        document = self.document
        parameter = document.parameters.get(path)
        if parameter is not None:
            return parameter.amount.number
        if path in CONSTANTS:
            return CONSTANTS[path]
        dimension = document.dimensions.get(path)
        if dimension is not None:
            return self._dimension(dimension)
        name, dot, rest = path.partition(".")
        entity = document.entities.get(name)
        if entity is None:
            raise self.unknown(name)
        if not dot:
            if entity.kind == "point":
                return self.point(path)
            raise self._no_value(entity)
        found = property_of(document, entity, rest)
        if found is not None:
            return found
        if rest in point_offsets(entity):
            return self.point(path)
        raise self._no_property(entity, rest)

    def point(self, handle: str) -> Vec:
        """Place of a point by its handle; the point is there."""
        at = self.document.point_at(handle)
        return Vec(float(self.document.values[at]), float(self.document.values[at + 1]))

    def operand(self, path: str) -> Any:
        """A point as `Vec`, another entity as its curve, else a number."""
        parts = split_handle(path)
        entity = self.document.entities.get(parts.name) if parts else None
        if parts and entity is not None and not parts.point and entity.kind != "point":
            return curve_of(self.document, entity)
        return self.value(path)

    def quantity(self, path: str) -> str:
        """``length``, ``angle`` or ``area`` if a name is one, else empty."""
        dimension = self.document.dimensions.get(path)
        if dimension is not None:
            return DIMENSIONS[dimension.kind].quantity
        if path in self.document.parameters:
            return self._quantity_of_parameter(path)
        name, _, rest = path.partition(".")
        entity = self.document.entities.get(name)
        if entity is None or not rest or rest in point_offsets(entity):
            return ""
        return "angle" if rest in ANGLES else "length"

    def names(self) -> list[str]:
        """Names that have a value by themselves, and entities."""
        document = self.document
        return [*document.parameters, *document.dimensions, *document.entities]

    def unknown(self, name: str) -> NoValueError:
        """The error of a name that nothing has."""
        near = closest(name, self.names())
        help_ = f"did you mean `{near[0]}`?" if near else f"make it a parameter: `param {name} 10`"
        return NoValueError(f"no parameter, dimension or entity `{name[:60]}`", help_)

    def _quantity_of_parameter(self, name: str) -> str:
        known = self._quantities
        if known is None:  # the outermost question: parameters that share others are asked once
            self._quantities = {}
            try:
                return self._quantity_of_parameter(name)
            finally:
                self._quantities = None
        if name not in known:
            known[name] = ""  # of a parameter that reads itself, and below the greatest depth
            if len(known) <= _MOST_PARAMETERS:
                text = self.document.parameters[name].amount.text
                known[name] = compiled(text).quantity(self)
        return known[name]

    _quantities: dict[str, str] | None = None

    def _dimension(self, dimension: Dimension) -> float:
        free = dimension.derived or dimension.value is None
        if free and self.measure is not None:
            return self.measure(dimension)
        amount = dimension.value or dimension.low or dimension.high
        assert amount is not None
        return amount.number

    def _no_value(self, entity: Entity) -> NoValueError:
        have = ", ".join(f"`{entity.name}.{p}`" for p in property_names(entity)[:4])
        return NoValueError(f"`{entity.name}` is a {entity.kind}, not a number", f"it has {have}")

    def _no_property(self, entity: Entity, name: str) -> NoValueError:
        names = property_names(entity)
        near = closest(name, names)
        have = ", ".join(f"`{p}`" for p in names[:8])
        help_ = f"did you mean `{entity.name}.{near[0]}`?" if near else f"it has {have}"
        return NoValueError(f"{entity.name}, a {entity.kind}, has no `{name[:40]}`", help_)
