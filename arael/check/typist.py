"""Type-checking context of one constraint, and error helpers for all rules."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field

from arael.check.binding import (
    BROKEN,
    Binding,
    Broken,
    Collection,
    Entity,
    OptionalValue,
    RefList,
    describe,
)
from arael.check.declared import Declarations
from arael.check.field_reads import read_column
from arael.check.guards import Fact
from arael.check.limits import MAX_EXPANDED, MAX_NESTING, MAX_OPERATIONS
from arael.check.paths import Paths
from arael.check.report import Reporter
from arael.check.scope import ConstantBinder, Scope
from arael.check.typed import BOOL, STRING, Apply, MatrixType, Typed
from arael.check.types import size_of
from arael.check.units_messages import report_units
from arael.check.units_typing import Units
from arael.diagnostics.records import Label, Span
from arael.runtime.layout import Slot, Step
from arael.syntax import tree

Handler = Callable[["Typist", tree.Expr], Binding]


@dataclass
class Slots:
    """The rows a constraint reads, by the path to them; the first is its own.

    `needs` are the optional refs on the path to a row, by the number of its slot. `arguments` has
    the numbers of expressions that parameters are looked up at, `look_ups` those of the look-ups.
    """

    items: list[Slot]
    needs: dict[int, tuple[tuple[Entity, str], ...]] = field(default_factory=dict)
    arguments: dict[Hashable, int] = field(default_factory=dict)
    look_ups: dict[Hashable, int] = field(default_factory=dict)

    def of(self, entity: Entity) -> int:
        """Number of the slot for the row of `entity`."""
        for i, slot in enumerate(self.items):
            if slot.steps == entity.steps:
                return i
        self.items.append(Slot(entity.steps, entity.place.table.path))
        if entity.needs:
            self.needs[len(self.items) - 1] = entity.needs
        return len(self.items) - 1

    def steps(self, number: int) -> tuple[Step, ...]:
        """Return the path to the row of a slot."""
        return self.items[number].steps


@dataclass
class Typist:
    """Types the expressions of one body.

    Attributes
    ----------
    facts : optionals proved present at this point of the constraint
    calls : functions being expanded, with the places of their calls
    operations : scalar operations so far
    expansion : expressions so far within calls of functions
    origins : declaration of each value that an expression reads
    units : units of expressions
    """

    declarations: Declarations
    report: Reporter
    handlers: Mapping[type, Handler]
    scope: Scope
    constant: ConstantBinder
    slots: Slots
    ways: Paths | None = None  # None in constants, which have no entities
    facts: frozenset[Fact] = frozenset()
    calls: list[tuple[str, Span]] = field(default_factory=list)
    operations: int = 0
    expansion: int = 0
    exhausted: bool = False
    nesting: int = 0
    origins: dict[Typed, Label] = field(default_factory=dict)
    units: Units = field(default_factory=Units)
    expanded: dict[tuple[str, tuple[Typed, ...]], Binding] = field(default_factory=dict)
    formulas: dict[tuple[tuple[Step, ...], str], Typed | Broken | None] = field(
        default_factory=dict
    )  # formulas of components by row and path; None while one is being typed

    @property
    def paths(self) -> Paths:
        """Resolves paths between entities."""
        assert self.ways is not None, "a constant has no entities"
        return self.ways

    # --- typing -------------------------------------------------------------------------------

    def visit(self, node: tree.Expr) -> Binding:
        """The binding of `node`: a value, an entity, a collection."""
        if self.exhausted:
            return BROKEN
        if self.nesting >= MAX_NESTING:
            self.exhausted = True
            return self.fail(
                "E0607",
                node.span,
                "expression is nested too deeply",
                label=f"more than {MAX_NESTING} levels, functions included",
                help=["split it up with `let`"],
            )
        self.nesting += 1
        try:
            binding = self.handlers[type(node)](self, node)
        finally:
            self.nesting -= 1
        if self.report.observe is not None:
            unit = self.units.of(binding) if isinstance(binding, Typed) else None
            self.report.observe(node, binding, unit)
        return binding

    def value(self, node: tree.Expr) -> Typed | Broken:
        """The value of `node`: a number of any shape, or a boolean."""
        return self.as_value(self.visit(node), node.span)

    def as_value(self, binding: Binding, span: Span) -> Typed | Broken:
        """`binding` as a value; reports an error if it is not one."""
        if isinstance(binding, OptionalValue):
            return self.read_optional(binding, span)
        if isinstance(binding, Broken):
            return BROKEN
        if not isinstance(binding, Typed):
            hint = ["name one of its fields"] if isinstance(binding, Entity) else []
            if isinstance(binding, RefList):
                hint = [f"write `sum(k in {span.text}) {{ ... }}`, or `{span.text}[0]` for one"]
            if isinstance(binding, Collection):
                path = span.text if "." in span.text else f"self.{span.text}"
                hint = [
                    f"`sum(row in {path}) {{ ... }}` adds over its rows; one row is reached by a "
                    'ref, and held in the data: `"fixed": true`'
                ]
            return self.fail(
                "E0304",
                span,
                "expected a value here",
                label=f"this is {describe(binding)}",
                help=hint,
            )
        if binding.type == STRING:
            return self.fail(
                "E0304", span, "text cannot be computed with", label="this is a string"
            )
        return binding

    def number(self, node: tree.Expr) -> Typed | Broken:
        """The value of `node`, which must not be a boolean."""
        return self.as_number(self.visit(node), node.span)

    def as_number(self, binding: Binding, span: Span) -> Typed | Broken:
        """`binding` as a value that is not a boolean; reports an error if it is not one."""
        value = self.as_value(binding, span)
        if isinstance(value, Typed) and value.type == BOOL:
            return self.fail(
                "E0307",
                span,
                "expected a number here",
                label="this is a bool",
                help=["turn it into a number: `if ... then 1 else 0`"],
            )
        return value

    def presence_of(self, binding: Binding, span: Span) -> Typed | Broken | None:
        """Presence test of `binding`; None for the bindings of a model file."""
        return None

    def read_optional(self, optional: OptionalValue, span: Span) -> Typed | Broken:
        """The value of an optional that is proved present."""
        return read_column(self, optional.entity, optional.field, span)

    def make(self, node: Typed, cost: int = 0) -> Typed | Broken:
        """Count `node` against the limits of a constraint; `cost` if it is not one per scalar."""
        self.operations += max(cost, size_of(node.type))
        self.expansion += bool(self.calls)
        if self.operations > MAX_OPERATIONS or self.expansion > MAX_EXPANDED:
            return self._too_large(node.span)
        misfit = self.units.note(node)
        if misfit is not None:
            report_units(self, node, misfit)
        return node

    def _too_large(self, span: Span) -> Broken:
        self.exhausted = True
        if self.expansion > MAX_EXPANDED:
            what = f"more than {MAX_EXPANDED} operations come from calls of functions"
            help_ = "functions are inlined at each call: one that calls another twice doubles it"
        else:
            what = f"more than {MAX_OPERATIONS} scalar operations, functions expanded"
            help_ = "split the constraint, or precompute parts as data"
        return self.fail("E0606", span, "expression is too large", label=what, help=[help_])

    def apply(self, node: tree.Expr, name: str, args: Sequence[Typed], type_: object) -> Binding:
        """An operation whose types have been checked."""
        result = Apply(type=type_, span=node.span, name=name, args=tuple(args))  # type: ignore[arg-type]
        return self.make(result, _cost(name, args, result))

    # --- context ------------------------------------------------------------------------------

    @contextmanager
    def knowing(self, facts: frozenset[Fact]) -> Iterator[None]:
        """Context in which these optionals are present as well."""
        before = self.facts
        self.facts = before | facts
        try:
            yield
        finally:
            self.facts = before

    @contextmanager
    def inside(self, name: str, call: Span, scope: Scope) -> Iterator[None]:
        """Context of the body of function `name`, called at `call`."""
        before = self.scope
        self.scope = scope
        self.calls.append((name, call))
        try:
            yield
        finally:
            self.scope = before
            self.calls.pop()

    # --- speaking -----------------------------------------------------------------------------

    def fail(
        self,
        code: str,
        span: Span,
        message: str,
        *,
        label: str = "",
        labels: Sequence[Label] = (),
        notes: Sequence[str] = (),
        help: Sequence[str] = (),
    ) -> Broken:
        """Report an error; inside a function with a label at its call."""
        here = list(labels)
        if self.calls:
            name, call = self.calls[0]
            here.append(Label(call, f"in this call of `{name}`"))
        self.report.error(code, span, message, label=label, labels=here, notes=notes, help=help)
        return BROKEN

    def origin(self, value: Typed) -> list[Label]:
        """The declaration of a value that is read directly."""
        label = self.origins.get(value)
        return [label] if label else []


def _cost(name: str, args: Sequence[Typed], result: Apply) -> int:
    """Scalar operations of an operation, roughly."""
    size = size_of(result.type)
    if name == "mul" and args and isinstance(args[0].type, MatrixType):
        return size * args[0].type.columns
    if name == "mul" and len(args) == 2 and isinstance(args[1].type, MatrixType):
        return size * args[1].type.rows
    return max(size, *(size_of(a.type) for a in args)) if args else size
