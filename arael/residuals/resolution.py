"""Name resolution in a formula given at run time.

In this order: a data column or a named row of the formula itself; a parameter of any runtime
residual of the model; a named expression (``width``, ``L0.length``); a field of the model's root
(``poses[3].pos.x``, ``gamma``); a constant. The formula's own names shadow those of the model.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from arael.check import access
from arael.check.binding import BROKEN, Binding, Broken
from arael.check.declared import Declarations
from arael.check.expressions import HANDLERS
from arael.check.report import Reporter
from arael.check.scope import Candidate, ConstantScope
from arael.check.suggest import did_you_mean
from arael.check.typed import (
    INT,
    REAL,
    STRING,
    Literal_,
    Read,
    VectorType,
)
from arael.check.typist import Slots
from arael.diagnostics.records import Span
from arael.face.ref import Refs
from arael.residuals.dotted import dotted_text, within
from arael.residuals.expression import Definition, Expression
from arael.residuals.parameters import parameter_table
from arael.residuals.reader import FormulaReads, Reader, Surroundings, read, slot_of
from arael.residuals.schema import Maybe, Row, Rows, type_of
from arael.runtime.layout import Column, Slot, Step, Target
from arael.syntax import tree

MAX_FOLLOWED = 50
"""Maximum depth of nested named expressions."""


@dataclass
class Names:
    """The scope for the rules of the language, after the names of the formula."""

    constants: ConstantScope
    reader: Reader | None = None

    def candidates(self, name: str) -> list[Candidate]:
        """A constant; other names were looked up before."""
        return self.constants.candidates(name)

    def names(self) -> Iterable[str]:
        """Candidates for the correction of a misspelt name."""
        if self.reader is None:
            return []
        frame = self.reader.frames[-1]
        around = self.reader.around
        return [
            *frame._data,
            *frame.entities,
            *around.names(),
            *around.schema.members(ROOT),
            *self.constants.names(),
        ]

    def advice(self, name: str) -> list[str]:
        """Help for the unknown name `name`."""
        reader = self.reader
        if reader is None or did_you_mean(name, self.names()):
            return []
        frame = reader.frames[-1]
        longer = within(name, reader.around.names())
        if longer:
            return [_there_is(longer)]
        return [f"pass it to `{frame.label}` as a parameter, as data or as an entity"]


ROOT = Row((Step("root"),), "", known="")


def reader_for(
    expression: Expression,
    path: str,
    around: Surroundings,
    declarations: Declarations,
    report: Reporter,
    constant: Any,
) -> Reader:
    """The typist of one residual whose rows are the table `path`."""
    scope = Names(ConstantScope(declarations, constant, inside="a formula"))
    reader = Reader(declarations, report, READERS, scope, constant, Slots([Slot((), path)]), None)
    scope.reader = reader
    reader.around, reader.reads, reader.frames = around, FormulaReads(path), [expression]
    return reader


def _name(t: Reader, node: tree.Name) -> Any:
    if t.calls:  # inside a function: its parameters and constants
        return access.name(t, node)
    frame, name = t.frames[-1], node.id
    if len(t.frames) == 1 and t.scope.candidates(name):  # the argument of a loss
        return access.name(t, node)
    if name in frame._data:
        return _data(t, frame, name, node.span)
    if name in frame.entities:
        return _entity(t, frame, name)
    owner = t.around.parameter_owner(name)
    if owner is not None:
        return _parameter(t, owner, name, node.span)
    definition = t.around.definition(name)
    if definition is not None:
        return _follow(t, definition, node)
    if name == "root":
        return ROOT
    if name in t.around.schema.members(ROOT):
        return member(t, ROOT, name, node.span, node.span)
    return access.name(t, node)


def _place(t: Reader, expression: Expression, name: str) -> str:
    """Path of a column of `expression` in the residual's rows."""
    if expression is t.frames[0]:
        return name
    t.reads.needs[expression.label] = None
    return f"{expression.label}.{name}"


def _data(t: Reader, expression: Expression, name: str, span: Span) -> Binding:
    path = _place(t, expression, name)
    shape = expression._data[name].shape[1:]
    if path not in t.reads.columns:
        kind = "real" if not shape else f"vec<{shape[0]}>"
        t.reads.columns[path] = Column(path, "real", shape, "data", kind, expression.label)
        t.reads.data[path] = expression, name
    type_ = VectorType(shape[0]) if shape else REAL
    return t.make(Read(type=type_, span=span, slot=0, column=path, version="data"))


def _entity(t: Reader, expression: Expression, name: str) -> Row:
    refs = expression.entities[name]
    row_name = name if len(refs) == 1 else None
    return _through(t, _place(t, expression, name), refs._table.layout.path, refs, row_name)


def _through(t: Reader, path: str, table: str, refs: Refs | None, row_name: str | None) -> Row:
    """The target row of a ref column of the residual's rows."""
    if path not in t.reads.columns:
        target = Target(table, "", (), path)
        t.reads.columns[path] = Column(path, "int", (), "ref", "ref", path, target=target)
        t.reads.refs[path] = refs
    return Row((Step("ref", path),), table, known=row_name, refs=refs if row_name else None)


def _parameter(t: Reader, owner: Expression, name: str, span: Span) -> Binding:
    t.reads.needs[owner.label] = None
    table = parameter_table(owner.label)
    row = _through(t, f"@{owner.label}", table, None, None)
    column = next(c for c in owner.parameters.columns if c.path == name)
    assert column.param is not None
    read = Read(
        type=type_of(column),
        span=span,
        slot=slot_of(t, row),
        column=name,
        version="trial",
        parameter=column.param.kind,
    )
    return t.make(read)


def _dotted(t: Reader, node: tree.Attribute) -> Any:
    """The value of an expression with a dotted name; None if `node` is something else."""
    text = "" if t.calls else dotted_text(node)
    if not text:
        return None
    frame, first = t.frames[-1], text.partition(".")[0]
    argument = len(t.frames) == 1 and t.scope.candidates(first)
    if argument or first in frame._data or first in frame.entities:
        return None
    definition = t.around.definition(text)
    if definition is not None:
        return _follow(t, definition, node)
    longer_names = within(first, t.around.names())
    if not longer_names or any(text.startswith(f"{name}.") for name in longer_names):
        return None
    return t.fail(
        "E0201",
        node.span,
        f"unknown name `{text}`",
        label="no expression has this name",
        help=did_you_mean(text, longer_names)
        or [f"there is {', '.join(f'`{longer}`' for longer in longer_names[:12])}"],
    )


def _there_is(names: list[str]) -> str:
    return f"there is {', '.join(f'`{name}`' for name in names[:12])}"


def _follow(t: Reader, definition: Definition, node: tree.Expr) -> Any:
    """The value of a named expression, in its own scope."""
    if definition in t.frames or len(t.frames) > MAX_FOLLOWED:
        start = t.frames.index(definition) if definition in t.frames else 0
        circle = [expression.label for expression in (*t.frames[start:], definition)]
        return t.fail(
            "E0764",
            node.span,
            f"expression depends on itself: {' -> '.join(circle[:6])}",
            label="depends on its own value",
            help=["give one of them as a number, or make it a parameter"],
        )
    t.reads.needs[definition.label] = None
    key = (f"={definition.label}", ())
    if key not in t.expanded:
        t.frames.append(definition)
        try:
            t.expanded[key] = t.value(definition._tree)
        finally:
            t.frames.pop()
    return t.expanded[key]


def member(t: Reader, row: Row, name: str, span: Span, name_span: Span) -> Any:
    """The binding of the field `name` of the struct at `row`."""
    schema, path = t.around.schema, row.prefix + name
    column = schema.columns.get((row.table, path))
    if column is not None:
        return _column(t, row, column, span)
    if (row.table, path) in schema.values:
        return Row(row.steps, row.table, f"{path}.", row.known, row.refs, row.needs)
    if (row.table, path) in schema.collections:
        return Rows(row, schema.collections[row.table, path].path, path)
    if name == "parent" and row.table:
        return _parent(t, row)
    struct = schema.tables[row.table].struct if row.table in schema.tables else "it"
    return t.fail(
        "E0204",
        name_span,
        f"`{row.prefix[:-1] or struct}` has no field `{name}`",
        label="unknown field",
        help=did_you_mean(name, schema.members(row))
        or [f"it has {', '.join(schema.members(row)[:12])}"],
    )


def _parent(t: Reader, row: Row) -> Row:
    if row.prefix:
        holder = row.prefix[:-1].rpartition(".")[0]
        prefix = f"{holder}." if holder else ""
        return Row(row.steps, row.table, prefix, row.known, row.refs, row.needs)
    table = t.around.schema.tables[row.table]
    holder = table.field.rpartition(".")[0]
    prefix = f"{holder}." if holder else ""
    if not table.parent:
        return Row(ROOT.steps, "", prefix, "")
    return Row((*row.steps, Step("parent")), table.parent, prefix, needs=row.needs)


def _column(t: Reader, row: Row, column: Column, span: Span) -> Any:
    if column.role == "ref":
        assert column.target is not None
        optional = (row.table, column.path) in t.around.schema.optionals
        needs = (*row.needs, (row, column.path)) if optional else row.needs
        return Row((*row.steps, Step("ref", column.path)), column.target.table, needs=needs)
    type_ = type_of(column)
    if column.role in ("skip", "constraint_index") or type_ == STRING:
        return t.fail(
            "E0304",
            span,
            f"`{column.path}` cannot be read in an expression",
            label=f"this is `{column.type}`",
        )
    if (row.table, column.path) in t.around.schema.optionals:
        return Maybe(row, column)
    return read(t, row, column, span)


def _attribute(t: Reader, node: tree.Attribute) -> Any:
    named = _dotted(t, node)
    if named is not None:
        return named
    owner: Any = t.visit(node.obj)
    if isinstance(owner, Broken):
        return BROKEN
    if isinstance(owner, Row):
        return member(t, owner, node.name, node.span, node.name_span)
    if isinstance(owner, Rows):
        return t.fail(
            "E0304",
            node.obj.span,
            f"`{node.obj.span.text}` is a collection",
            label="the row is missing",
            help=[f"name one row: `{node.obj.span.text}[0].{node.name}`"],
        )
    return _again(t, node, owner, access.attribute)


def _index(t: Reader, node: tree.Index) -> Any:
    owner: Any = t.visit(node.obj)
    if isinstance(owner, Broken):
        return BROKEN
    if isinstance(owner, Row) and (count := _refs_of(t, owner)):
        (at, *others) = node.indices
        if others or isinstance(at, tree.Slice):
            return t.fail("E0305", node.span, "an element of a list of refs has one index")
        i = access.constant_index(t, at, count, f"`{node.obj.span.text}`")
        return BROKEN if i is None else member(t, owner, str(i), node.span, node.span)
    if not isinstance(owner, Rows):
        return _again(t, node, owner, access.index)
    (at, *others) = node.indices
    if others or isinstance(at, tree.Slice):
        indices_text = len(node.indices) if others else "a slice"
        return t.fail(
            "E0305", node.span, "a collection takes 1 index", label=f"found {indices_text}"
        )
    value = t.number(at)
    if isinstance(value, Broken):
        return BROKEN
    if not isinstance(value, Literal_) or value.type != INT or value.value < 0:
        return t.fail(
            "E0305",
            node.indices[0].span,
            "the index of a row is a whole number, counted from 0",
            label="not such a number",
            help=["pass varying rows to the residual as an entity: `entities={'p': rows}`"],
        )
    if owner.owner.known is None:
        return t.fail(
            "E0305",
            node.span,
            "an index is possible only in a collection of a single row",
            label=f"`{node.obj.span.text}` varies with the row",
            help=["pass the rows to the residual as an entity"],
        )
    number = int(value.value)
    refs = t.around.element(owner.owner, owner.table, number)
    if isinstance(refs, int):
        return t.fail(
            "E0305",
            node.indices[0].span,
            f"there is no row {number}",
            label=f"`{node.obj.span.text}` has {refs} row{'' if refs == 1 else 's'}",
        )
    row_name = f"{owner.owner.known}.{owner.name}[{number}]".removeprefix(".")
    # An index in a named expression refers to its own entities, so the name is a prefix.
    frame = t.frames[-1]
    outer = frame is t.frames[0] or owner.owner.refs is None
    return _through(
        t, row_name if outer else f"{frame.label}.{row_name}", owner.table, refs, row_name
    )


def _refs_of(t: Reader, row: Row) -> int:
    """Number of refs of the list of refs at `row`; 0 for a struct."""
    held = t.around.schema.values.get((row.table, row.prefix[:-1]))
    return held.refs if held is not None else 0


def _sum(t: Reader, node: tree.Sum) -> Any:
    return t.fail(
        "E0612",
        node.span,
        "sums over lists are part of model files",
        label="this formula is added at run time",
        help=["write the terms: `row.knots[0].x + row.knots[1].x`"],
    )


def _again(t: Reader, node: Any, owner: Any, rule: Any) -> Any:
    """Apply a rule of the language to `node`, whose owner is resolved already."""
    t.worked_out = node.obj, owner
    return rule(t, node)


READERS: dict[type, Any] = {
    **HANDLERS,
    tree.Name: _name,
    tree.Attribute: _attribute,
    tree.Index: _index,
    tree.Sum: _sum,
}
