"""Bindings: what a name or an expression refers to during checking."""

from __future__ import annotations

from dataclasses import dataclass

from arael.check.declared import FieldDecl
from arael.check.places import Place, TableSite
from arael.check.typed import Typed
from arael.diagnostics.records import Span
from arael.runtime.layout import Step


@dataclass(frozen=True)
class Entity:
    """A struct at a place, in the row reached from the constraint's own by `steps`.

    `holder` is the entity that owns the row, if a ref determines it (``feature`` in
    ``pose.info.features`` belongs to ``pose.info``). `needs` are the optional refs on the path: the
    entity that has each, and its column. If one of them is null the row does not exist.
    """

    steps: tuple[Step, ...]
    place: Place
    holder: Entity | None = None
    needs: tuple[tuple[Entity, str], ...] = ()

    def same(self, other: Entity) -> bool:
        """Whether both are the same struct of the same row."""
        return self.steps == other.steps and self.place is other.place


@dataclass(frozen=True)
class Collection:
    """A collection, possibly where a value is expected; `owner` contains it."""

    owner: Entity
    site: TableSite


@dataclass(frozen=True)
class RefList:
    """A list of refs of fixed length; `owner` has the field."""

    owner: Entity
    field: FieldDecl


@dataclass(frozen=True)
class OptionalValue:
    """An optional scalar, vector or matrix: a presence test or a value, depending on its use."""

    entity: Entity
    field: FieldDecl
    span: Span


@dataclass(frozen=True)
class Broken:
    """Stands for something with a reported error; suppresses consequential errors."""


BROKEN = Broken()

Binding = Typed | Entity | Collection | RefList | OptionalValue | Broken


def describe(binding: Binding) -> str:
    """Description of a binding for messages."""
    if isinstance(binding, Typed):
        return str(binding.type)
    if isinstance(binding, Entity):
        kind = "component" if binding.place.struct.component else "struct"
        return f"the {kind} {binding.place.struct.name}"
    if isinstance(binding, Collection):
        return f"a collection of {binding.site.place.struct.name}"
    if isinstance(binding, RefList):
        return f"a list of {len(binding.field.elements)} refs"
    if isinstance(binding, OptionalValue):
        return f"{binding.field.text}"
    return "nothing"
