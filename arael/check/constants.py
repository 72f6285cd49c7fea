"""Rule: a constant is a number (or a list of numbers) with a value at compile time.

Allowed: ``const DEG = pi / 180``, constants in any order, functions of the model with constant
arguments.

Not allowed: a constant that depends on itself, ``1 / 0``, names of data or parameters.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from arael.check.arithmetic import NotConstant, Values, evaluate
from arael.check.binding import BROKEN, Binding, Broken
from arael.check.declared import Declarations
from arael.check.expressions import HANDLERS
from arael.check.report import Reporter
from arael.check.scope import ConstantScope
from arael.check.typed import INT, REAL, Literal_, Named, Pack, Typed, ValueType
from arael.check.typist import Slots, Typist
from arael.check.units_quantities import NUMBER, Quantity, spread
from arael.diagnostics.records import Span
from arael.syntax import tree


@dataclass(frozen=True)
class Constant:
    """A constant value with its type and unit; `values` is flat."""

    type: ValueType
    values: Values
    unit: Quantity = NUMBER


class Constants:
    """The constants of a model, evaluated on first use."""

    def __init__(self, declarations: Declarations, report: Reporter) -> None:
        self.declarations = declarations
        self.report = report
        self.done: dict[str, Typed | Broken] = {}
        self.open: list[str] = []

    def check_all(self) -> None:
        """Evaluate every constant, so that mistakes in unused ones are found too."""
        for name, node in self.declarations.consts.items():
            self.named(name, node.name.span)

    def named(self, name: str, use: Span) -> Binding:
        """The constant `name` as an expression at `use`."""
        if name not in self.done:
            if name in self.open or len(self.open) > 100:
                return self._circle(name, use)
            self.open.append(name)
            self.done[name] = self._work_out(name, self.declarations.consts[name].value)
            self.open.pop()
        value = self.done[name]
        return replace(value, span=use) if isinstance(value, Literal_) else value

    def evaluate(self, node: tree.Expr) -> Constant | None:
        """The value of a constant expression; None after an error."""
        typed, unit = self._typed(node)
        if isinstance(typed, Broken):
            return None
        try:
            return Constant(typed.type, evaluate(typed), unit)
        except NotConstant as wrong:
            self.report.error(
                "E0309",
                node.span,
                "cannot evaluate this constant",
                label=f"`{wrong.node.span.text}` {wrong.reason}",
            )
            return None

    def _work_out(self, name: str, node: tree.Expr) -> Typed | Broken:
        typed, unit = self._typed(node)
        if isinstance(typed, Broken):
            return typed
        if typed.type not in (REAL, INT):
            return _as_numbers(name, typed, unit)
        value = self.evaluate(node)
        if value is None:
            return BROKEN
        return Literal_(
            type=typed.type,
            span=node.span,
            value=value.values[0],
            unit=unit,
            constant=Named(name, 0, False, typed),
        )

    def _typed(self, node: tree.Expr) -> tuple[Typed | Broken, Quantity]:
        scope = ConstantScope(self.declarations, self.named)
        t = Typist(self.declarations, self.report, HANDLERS, scope, self.named, Slots([]))
        value = t.value(node)
        return value, NUMBER if isinstance(value, Broken) else t.units.of(value)

    def _circle(self, name: str, use: Span) -> Broken:
        start = self.open.index(name) if name in self.open else 0
        circle = " -> ".join([*self.open[start:], name])
        self.report.error(
            "E0213",
            use,
            f"constant depends on itself: {circle}",
            label="depends on its own value",
        )
        return BROKEN


def _as_numbers(name: str, typed: Typed, unit: Quantity) -> Typed:
    """A vector or matrix as its numbers, which have their units wherever it is read."""
    try:
        values = evaluate(typed)
    except NotConstant:
        return typed
    items = tuple(
        Literal_(
            type=REAL,
            span=typed.span,
            value=value,
            unit=part_unit,
            constant=Named(name, k, False, typed),
        )
        for k, (value, part_unit) in enumerate(zip(values, spread(unit, len(values)), strict=True))
    )
    return Pack(type=typed.type, span=typed.span, items=items)
