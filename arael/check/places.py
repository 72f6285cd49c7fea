"""Places of structs: the tables of a model, and the structs held by value within their rows."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Literal

from arael.check.declared import Declarations, FieldDecl, StructDecl
from arael.check.limits import MAX_COLUMNS, MAX_TABLES
from arael.check.report import Reporter


@dataclass(eq=False)
class Place:
    """A struct at one place: the row of a table (`prefix` ""), or a part of it (``info.``).

    Attributes
    ----------
    owner : the place of the struct that contains this one, by value or in a collection
    optionals : paths within the row of the enclosing optional structs, including this one
    values : structs held by value, by field name
    collections : collections, by field name
    """

    table: TableSite
    struct: StructDecl
    prefix: str
    owner: Place | None
    optionals: tuple[str, ...] = ()
    values: dict[str, Place] = field(default_factory=dict)
    collections: dict[str, TableSite] = field(default_factory=dict)

    def column(self, field_: FieldDecl) -> str:
        """Path of a field's column within the row."""
        return self.prefix + field_.name


@dataclass(eq=False)
class TableSite:
    """A collection at one place, or the root."""

    path: str
    collection: Literal["root", "list", "deque", "arena"]
    parent: str
    path_in_parent: str
    declared: FieldDecl | None
    place: Place = field(init=False)

    def places(self) -> Iterator[Place]:
        """The row's own struct, then the structs held by value in it, in order of declaration."""
        waiting = [self.place]
        while waiting:
            place = waiting.pop()
            yield place
            waiting.extend(reversed(list(place.values.values())))


def stored_fields(place: Place) -> Iterator[tuple[Place, FieldDecl]]:
    """Columns of an entity: its own parameters, and all columns of its components."""
    for declared in place.struct.fields.values():
        if declared.component:
            yield from stored_fields(place.values[declared.name])
        elif declared.kind == "column" and (declared.param or place.struct.component):
            yield place, declared


class Sites:
    """All tables of a model, owners before owned."""

    def __init__(self, declarations: Declarations, root: StructDecl, report: Reporter) -> None:
        self.declarations = declarations
        self.report = report
        self.columns = 0
        self.full = False
        self.tables: dict[str, TableSite] = {}
        self.root = TableSite("", "root", "", "", None)
        waiting = [self.root]
        self._lay(self.root, root, None)
        self.tables[""] = self.root
        while waiting:
            table = waiting.pop(0)
            for place in table.places():
                for name, inner in place.collections.items():
                    declared = place.struct.fields[name]
                    self._lay(inner, declarations.structs[declared.struct], place)
                    self.tables[inner.path] = inner
                    waiting.append(inner)
                    if len(self.tables) > MAX_TABLES and not self.full:
                        self._too_many(declared, f"more than {MAX_TABLES} collections")
            if self.full:
                break

    def places(self) -> Iterator[Place]:
        """Every place of every struct."""
        for table in self.tables.values():
            yield from table.places()

    def _lay(self, table: TableSite, struct: StructDecl, owner: Place | None) -> None:
        """Lay out one row of a table: its struct and the structs held by value in it."""
        table.place = Place(table, struct, "", owner)
        waiting = [table.place]
        while waiting and not self.full:
            place = waiting.pop()
            for declared in place.struct.fields.values():
                path = place.prefix + declared.name
                self.columns += max(1, len(declared.elements))
                if self.columns > MAX_COLUMNS:
                    self._too_many(declared, f"more than {MAX_COLUMNS} columns")
                    return
                if declared.kind == "struct":
                    optionals = (*place.optionals, path) if declared.optional else place.optionals
                    inner = self.declarations.structs[declared.struct]
                    value = Place(table, inner, path + ".", place, optionals)
                    place.values[declared.name] = value
                    waiting.append(value)
                elif declared.kind == "collection":
                    full = f"{table.path}.{path}" if table.path else path
                    place.collections[declared.name] = TableSite(
                        full, declared.collection, table.path, path, declared
                    )

    def _too_many(self, declared: FieldDecl, what: str) -> None:
        self.full = True
        self.report.error(
            "E0412",
            declared.span,
            f"the model unfolds into {what}",
            label="the limit is reached here",
            notes=[
                "a struct held by value at many places, whose owner is held at many places, "
                "multiplies"
            ],
            help=["keep the shared struct in one collection and refer to it with `ref`"],
        )
