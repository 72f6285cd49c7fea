"""Rows of a record: added, removed, and given another value."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from arael.sketch.document.records import Amount, Constraint, Dimension, Entity, Record
from arael.sketch.expressions.gradient import Program
from arael.sketch.layout import following, model, quantities, relations
from arael.sketch.layout.aliases import Aliases
from arael.sketch.layout.laid import Laid, acts, own_rows, scalars_of, shape_of
from arael.sketch.layout.operands import operands
from arael.sketch.layout.plan import Constant, Plan, Row, Sum, Use


class Laying(Aliases):
    """Plans of records become rows, guards and hidden unknowns."""

    # --- what plans ask -------------------------------------------------------------------

    def same(self, a: int, b: int) -> bool:
        """Whether two points, by offsets, are one place; after `refresh`."""
        return a == b or bool(self._root[a] == self._root[b])

    def lies_on(self, point: int, curve: str) -> bool:
        """Whether a `point_on` of its own holds a point on a curve."""
        return any(self.same(point, one) for one in self._on.get(curve, {}).values())

    def on_both(self, first: str, second: str) -> int | None:
        """A point that relations of its own hold on both of two curves; None: there is none."""
        points = self._on.get(first, {}).values()
        return next((point for point in points if self.lies_on(point, second)), None)

    def piece_of(self, name: str) -> int | None:
        """On which piece of a spline a `point_on` is to be; None: on the nearest."""
        return self._pieces.get(name)

    # --- rows -----------------------------------------------------------------------------

    def _plan(self, laid: Laid, values: NDArray[np.float64]) -> Plan:
        record = laid.record
        if isinstance(record, Entity):
            return own_rows(record, values, self)
        if isinstance(record, Constraint):
            args = operands(self.document, record.args)
            plan = relations.plan_of(record, args, values, self)
            if plan.piece >= 0:
                self._pieces[record.name] = plan.piece
            return plan
        assert isinstance(record, Dimension)
        document = self.document

        def program(text: str) -> Program | None:
            return following.program_of(document, record, text)

        return quantities.plan_of(
            record, operands(document, record.args), values, program, self.same
        )

    def _lay(self, laid: Laid, values: NDArray[np.float64]) -> None:
        name = laid.record.name
        plan = laid.plan = self._plan(laid, values)
        self._impossible.pop((name, -1), None)
        if self.document.is_changing:
            self._amid_changes[name] = None
        if plan.unguarded:
            self._unguarded[name] = None
        if plan.impossible:
            self._impossible[name, -1] = plan.impossible
        for hidden in plan.hidden:
            size = len(hidden.names)
            at = self._columns.take(size)
            self._grow()
            laid.hidden.append(at)
            self.x[at : at + size] = hidden.start(values)
            self.low[at : at + size], self.high[at : at + size] = hidden.low, hidden.high
            self._with_hidden[name] = None
        for row in plan.rows:
            laid.rows.append(self._add(self.rows, self.owner, name, row, laid))
        for one in plan.sums:
            laid.sums.append(self._add_sum(name, one, laid))
        for row in plan.guards:
            laid.guards.append(self._add(self.guards, self.guard_owner, name, row, laid))
        if any(setting.which == "guards" for setting in plan.settings):
            self._with_turning[name] = None
        if isinstance(laid.record, Dimension) and laid.record.value is not None:
            self._approach(laid, laid.record, values)

    def _approach(self, laid: Laid, dimension: Dimension, values: NDArray[np.float64]) -> None:
        """A new value is approached from what the quantity is now."""
        plan = cast("Plan", laid.plan)
        if not plan.settings:
            return
        args = operands(self.document, dimension.args)
        now = quantities.measure(
            dimension.kind, args, values, dimension.side, dimension.mode, self.same
        )
        amount = cast("Amount", dimension.value)
        number = quantities.inner(dimension.kind, amount.number)
        for setting in plan.settings:
            old, new = (setting.scale * one + setting.shift for one in (now, number))
            if setting.which == "rows":
                self._changes["rows", laid.rows[setting.at]] = (old, new)
            elif setting.which == "sums":
                factor = plan.sums[setting.at].parts[0][1]
                self._changes["rows", laid.sums[setting.at]] = (old / factor, new / factor)
            else:
                self._changes["guards", laid.guards[setting.at]] = (old, new)

    def _uses(self, uses: Iterable[Use], laid: Laid) -> list[int]:
        found = []
        for use in uses:
            if isinstance(use, Constant):
                at = self._take_constant(use.numbers)
                laid.constants.append(at)
                found.append(at)
            elif use >= 0:
                found.append(int(self._use[use]))
            else:
                found.append(self._hidden_column(laid, -1 - use))
        return found

    @staticmethod
    def _hidden_column(laid: Laid, number: int) -> int:
        assert laid.plan is not None
        for at, hidden in zip(laid.hidden, laid.plan.hidden, strict=True):
            if number < len(hidden.names):
                return at + number
            number -= len(hidden.names)
        raise IndexError(number)

    def _add(
        self, rows: Any, owner: list[str], name: str, row: Row, laid: Laid, quantity: bool = False
    ) -> int:
        at: int = rows.add(
            row.struct, self._uses(row.uses, laid), scalars_of(row.data), quantity=quantity
        )
        if rows.m > len(owner):
            owner += [""] * (rows.m - len(owner))
        count = rows.tables[row.struct].residuals
        owner[at : at + count] = [name] * count
        if rows is self.rows:
            if rows.m > len(self._is_equation):
                more = np.zeros(rows.m, dtype=bool)
                self._is_equation = np.concatenate([self._is_equation, more])
            self._is_equation[at : at + count] = not quantity
        return at

    def _add_sum(self, name: str, one: Sum, laid: Laid) -> int:
        """A sum of rows: the first is the row, an expression subtracts the others."""
        (first, factor), *others = one.parts
        data = {**first.data, "weight": factor, "value": one.offset / factor}
        at = self._add(self.rows, self.owner, name, Row(first.struct, first.uses, data), laid)
        read = [row for row, _ in others]
        numbers = [-factor for _, factor in others]
        tape = model.linear(len(others)) if others else None
        if one.program is not None:
            document = self.document
            geometry = [following.property_row(document, path) for path in one.program.geometry]
            read += [row for row in geometry if row is not None]
            numbers += [one.scale]
            numbers += [following.number_of(document, name) for name in one.program.numbers]
            tape = following.with_program(len(others), one.program.tape, len(geometry))
        if tape is not None:
            inputs = [
                self._add(self.rows, self.owner, name, row, laid, quantity=True) for row in read
            ]
            laid.inputs += inputs
            self.rows.add_expression(at, tape, inputs, (), numbers)
        for use, coefficient in one.terms:
            column = self._uses((use,), laid)[0]
            self.rows.add_term(at, column, coefficient)
        return at

    def _remove_rows(self, laid: Laid) -> None:
        """Rows, hidden unknowns and constants of a record."""
        for which, rows in (("rows", [*laid.rows, *laid.sums]), ("guards", laid.guards)):
            for row in rows:
                self._changes.pop((which, row), None)
        for row in (*laid.rows, *laid.sums, *laid.inputs):
            count = self.rows.tables[self.rows.struct(row)].residuals
            self.rows.remove(row)
            self.owner[row : row + count] = [""] * count
            self._is_equation[row : row + count] = False
        for row in laid.guards:
            count = self.guards.tables[self.guards.struct(row)].residuals
            self.guards.remove(row)
            self.guard_owner[row : row + count] = [""] * count
        if laid.plan is not None:
            for at, hidden in zip(laid.hidden, laid.plan.hidden, strict=True):
                size = len(hidden.names)
                self.low[at : at + size], self.high[at : at + size] = -np.inf, np.inf
                self._columns.release(at, size)
        self._with_hidden.pop(laid.record.name, None)
        self._unguarded.pop(laid.record.name, None)
        self._with_turning.pop(laid.record.name, None)
        for at in laid.constants:
            self.rows.release_constant(at)
            self.guards.release_constant(at)
        for numbers in (laid.rows, laid.sums, laid.inputs, laid.guards, laid.hidden):
            numbers.clear()
        laid.constants.clear()
        laid.plan = None

    def _set_value(self, laid: Laid, record: Record | None) -> bool:
        """Take in a dimension that differs in its numbers alone; whether it does."""
        old = laid.record
        if not isinstance(record, Dimension) or not isinstance(old, Dimension):
            return False
        was, shape = laid.shape or shape_of(old), shape_of(record)
        if was != shape or (laid.plan is None) != (not acts(record)):
            return False
        laid.record, laid.shape = record, shape
        if laid.plan is None:
            return True
        for setting in laid.plan.settings:
            amount = getattr(record, setting.amount)
            number = quantities.inner(record.kind, amount.number)
            value = setting.scale * number + setting.shift
            if setting.which == "rows":
                self._change("rows", laid.rows[setting.at], value)
            elif setting.which == "guards":
                self._change("guards", laid.guards[setting.at], value)
            else:
                factor = laid.plan.sums[setting.at].parts[0][1]
                self._change("rows", laid.sums[setting.at], value / factor)
        return True

    def _change(self, which: str, row: int, value: float) -> None:
        rows = self.rows if which == "rows" else self.guards
        old = self._changes.get((which, row), (rows.data(row, "value"), 0.0))[0]
        self._changes[which, row] = (old, value)
        rows.set_data(row, "value", value)
