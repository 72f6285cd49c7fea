"""A compiled model's tables, looked up by the names in formulas: fields, structs, collections."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from weakref import WeakKeyDictionary

from arael.check.typed import (
    BOOL,
    INT,
    REAL,
    EntitySite,
    MatrixType,
    ValueType,
    VectorType,
)
from arael.check.types import DATA_TYPES, FIXED_TYPES, PARAM_TYPES
from arael.compiled_model import CompiledModel
from arael.compiler.entities import StateModel, model_state
from arael.face.ref import Refs
from arael.residuals.declared import Declared, of_model
from arael.runtime.layout import ByValue, Column, Layout, Step, Table


@dataclass(frozen=True)
class Row:
    """One row of a table, or the struct within it at `prefix`, reached by `steps`.

    If it is the same row for all rows of the residual, `known` is its name (``poses[3]``, "" for
    the root) and `refs` a ref to it (None for the root). `needs` are the optional refs on the path:
    the row that has each, and its column.
    """

    steps: tuple[Step, ...]
    table: str
    prefix: str = ""
    known: str | None = None
    refs: Refs | None = None
    needs: tuple[tuple[Row, str], ...] = ()


@dataclass(frozen=True)
class Maybe:
    """An optional value of a row: a presence test or the value, depending on its use."""

    row: Row
    column: Column


@dataclass(frozen=True)
class Rows:
    """A collection, `field` of the struct at `owner`."""

    owner: Row
    table: str
    name: str


@dataclass
class Schema:
    """Lookups over a layout.

    Attributes
    ----------
    columns : fields with values; `optionals` : optional fields and structs
    states : state of each entity of the layout
    """

    layout: Layout
    columns: dict[tuple[str, str], Column] = field(default_factory=dict)
    optionals: set[tuple[str, str]] = field(default_factory=set)
    values: dict[tuple[str, str], ByValue] = field(default_factory=dict)
    collections: dict[tuple[str, str], Table] = field(default_factory=dict)
    tables: dict[str, Table] = field(default_factory=dict)
    states: list[StateModel] = field(default_factory=list)

    def __post_init__(self) -> None:
        for table in self.layout.tables:
            self.tables[table.path] = table
            if table.collection != "root":
                self.collections[table.parent, table.field] = table
            for column in table.columns:
                if column.role == "present":
                    self.optionals.add((table.path, column.path))
                else:
                    self.columns[table.path, column.path] = column
            for value in table.values:
                self.values[table.path, value.path] = value
        for entity in self.layout.entities:
            columns = tuple(self.columns[entity.table, use.column] for use in entity.params)
            site = EntitySite(entity.struct, entity.table, entity.prefix, columns)
            self.states.append(model_state(site))

    @cached_property
    def declared(self) -> Declared:
        """Functions and constants of the model."""
        return of_model(self.layout)

    def carried(self, table: str, column: str) -> bool:
        """Whether a column is stored data of a component, which may change with every step."""
        return any(
            state.entity.table == table and column in state.stored_at for state in self.states
        )

    def members(self, row: Row) -> list[str]:
        """Names of the members of the struct at `row`."""
        names: dict[str, None] = {}
        for table, path in (*self.columns, *self.values, *self.collections):
            if table == row.table and path.startswith(row.prefix):
                names[path[len(row.prefix) :].partition(".")[0]] = None
        return list(names)


_SCHEMAS: WeakKeyDictionary[CompiledModel, Schema] = WeakKeyDictionary()


def schema_of(compiled: CompiledModel) -> Schema:
    """The schema of a compiled model, made once for all its instances."""
    schema = _SCHEMAS.get(compiled)
    if schema is None:
        schema = _SCHEMAS[compiled] = Schema(compiled.layout)
    return schema


def type_of(column: Column) -> ValueType:
    """The value type of a column in expressions."""
    if column.param is not None and column.param.kind in PARAM_TYPES:
        return PARAM_TYPES[column.param.kind][0]
    name = column.type.removeprefix("param ").partition(" ")[0].rstrip("?")
    if name in DATA_TYPES:
        return PARAM_TYPES[name][0]
    if name in FIXED_TYPES and column.role != "constraint_index":
        return FIXED_TYPES[name]
    if len(column.shape) == 1:
        return VectorType(column.shape[0])
    if len(column.shape) == 2:
        return MatrixType(*column.shape)
    return {"int": INT, "bool": BOOL}.get(column.kind, REAL)
