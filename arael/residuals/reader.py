"""The typist of formulas given at run time, and the columns that they read."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any, Protocol

from arael.check.binding import BROKEN, Broken
from arael.check.typed import (
    BOOL,
    Apply,
    Present,
    Read,
    Typed,
)
from arael.check.typist import Typist
from arael.diagnostics.records import Label, Span
from arael.face.ref import Refs
from arael.residuals.expression import Definition, Expression
from arael.residuals.schema import Maybe, Row, Rows, Schema, type_of
from arael.runtime.layout import Column, Slot, Step
from arael.syntax import tree


class Surroundings(Protocol):
    """The part of its model that a formula can read."""

    schema: Schema

    def parameter_owner(self, name: str) -> Expression | None:
        """The residual that owns the parameter `name`."""

    def definition(self, name: str) -> Definition | None:
        """The named expression `name`."""

    def names(self) -> Iterable[str]:
        """Names of parameters and named expressions."""

    def element(self, owner: Row, path: str, index: int) -> Refs | int:
        """Element `index` of a collection, or their number."""


Unproved = dict[tuple[tuple[Step, ...], str, str], Span]
"""Optionals read without a test: the steps to the row, its table, the path."""


@dataclass
class FormulaReads:
    """The reads of a formula, from which the table of the residual's rows is built.

    Attributes
    ----------
    path : of that table
    columns : its columns by path, in the order in which they are read
    data : column -> the expression whose data it has, and their name there
    refs : ref column -> rows of the model; None for the one row of a parameter table
    needs : labels of the residuals and expressions that the formula depends on
    optionals : optionals that the formula reads without a test, and where
    guard_optionals : the same of the guard
    """

    path: str
    columns: dict[str, Column] = field(default_factory=dict)
    data: dict[str, tuple[Expression, str]] = field(default_factory=dict)
    refs: dict[str, Refs | None] = field(default_factory=dict)
    needs: dict[str, None] = field(default_factory=dict)
    optionals: Unproved = field(default_factory=dict)
    guard_optionals: Unproved = field(default_factory=dict)


class Reader(Typist):
    """Types one formula; `frames` are the expressions being read, the innermost last."""

    around: Surroundings
    reads: FormulaReads
    frames: list[Expression]
    worked_out: tuple[tree.Expr, Any] | None = None

    def visit(self, node: tree.Expr) -> Any:
        """The binding of `node`: a value, a row, a collection."""
        known, self.worked_out = self.worked_out, None
        if known is not None and known[0] is node:
            return known[1]
        return super().visit(node)

    def as_value(self, binding: Any, span: Span) -> Typed | Broken:
        """`binding` as a value; reports an error if it is a row or a collection."""
        if isinstance(binding, Maybe):
            return read(self, binding.row, binding.column, span)
        if isinstance(binding, Row | Rows):
            what = "a row" if isinstance(binding, Row) else "a collection"
            which = ["name one of its fields"]
            if isinstance(binding, Rows):
                which = [f"name one row: `{span.text}[0]`"]
            return self.fail(
                "E0304", span, "expected a value here", label=f"this is {what}", help=which
            )
        return super().as_value(binding, span)

    def presence_of(self, binding: Any, span: Span) -> Typed | Broken | None:
        """Presence test of an optional value, struct or ref."""
        if isinstance(binding, Maybe):
            return self._present(binding.row, binding.column.path, span)
        if not isinstance(binding, Row):
            return None
        path = binding.prefix[:-1]
        if (binding.table, path) in self.around.schema.optionals:
            return self._present(binding, path, span)
        if binding.needs:
            return self._present(binding, "", span)
        return self.fail(
            "E0502",
            span,
            f"`{span.text}` is always present",
            label="this is a row, not an optional",
            help=["only a field declared with `?` can be absent"],
        )

    def _present(self, row: Row, path: str, span: Span) -> Typed | Broken:
        """Whether `row` exists and `path` is present in it."""
        tests = [*row.needs, *([(row, path)] if path else [])]
        result: Typed | None = None
        for source, column in tests:
            slot = slot_of(self, source)
            test = self.make(Present(type=BOOL, span=span, slot=slot, column=column))
            if isinstance(test, Typed) and result is not None:
                test = self.make(Apply(type=BOOL, span=span, name="and", args=(result, test)))
            if isinstance(test, Broken):
                return BROKEN
            result = test
        assert result is not None
        return result


def slot_of(t: Reader, row: Row) -> int:
    """Number of the slot for `row`."""
    for number, slot in enumerate(t.slots.items):
        if slot.steps == row.steps:
            return number
    t.slots.items.append(Slot(row.steps, row.table))
    if row.needs:
        t.slots.needs[len(t.slots.items) - 1] = row.needs  # type: ignore[assignment]
    return len(t.slots.items) - 1


def read(t: Reader, row: Row, column: Column, span: Span) -> Typed | Broken:
    """The value of a field. Untested optionals are checked when the model is solved."""
    for source, path in (*row.needs, *([(row, column.within)] if column.within else [])):
        if not any(
            steps == source.steps and (known == path or known.startswith(f"{path}."))
            for steps, known in t.facts
        ):
            t.reads.optionals.setdefault((source.steps, source.table, path), span)
    moves = column.param is not None or t.around.schema.carried(row.table, column.path)
    node = Read(
        type=type_of(column),
        span=span,
        slot=slot_of(t, row),
        column=column.path,
        version="trial" if moves else "data",
        parameter="" if column.param is None else column.param.kind,
    )
    t.origins[node] = Label(span, f"declared as `{column.type}` at {column.where}")
    return t.make(node)
