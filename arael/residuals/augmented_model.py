"""A model instance together with its runtime residuals, as one problem."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import AraelError, Diagnostic
from arael.residuals.code import CodeUpdate
from arael.residuals.code_arguments import PlacedArgument
from arael.residuals.code_group import CodeGroup
from arael.residuals.code_hook import CodeHook, UpdateHook
from arael.residuals.derivation import Derived, state_of
from arael.residuals.expression import Expression
from arael.residuals.parameters import ParameterTable, parameter_table
from arael.residuals.reader import Unproved
from arael.runtime.assembly.structure import active_rows
from arael.runtime.evaluation.group_kernel import GroupKernel
from arael.runtime.layout import Entity, Group, Layout, Slot, Table, Use
from arael.runtime.machine.compiled import NativeTable, Program
from arael.runtime.machine.native_binding import Binding
from arael.runtime.store.access import Walker


class AugmentedModel:
    """Stands in for the store in the solver: the model's tables and those of its residuals.

    Parameters
    ----------
    layout : of the compiled model
    store : its data
    owners : expressions with parameters
    derived : the residuals
    bindings : bindings of native functions declared for the residuals
    codes : residuals by own code
    updates : functions called before each linearisation, with their arguments placed

    Attributes
    ----------
    derived : the residuals
    layout : the model's layout with the tables, entities and groups of the residuals appended
    tables : path -> table
    programs : per group, the program of the expression machine, or a separate kernel; None for
        groups in the kernels of the model
    rows_version : counts changes of the number of rows
    hooks : number of a group of residuals by own code -> makes what evaluates it in a problem
    updates : what is called before each linearisation
    """

    def __init__(
        self,
        layout: Layout,
        store: Any,
        owners: Sequence[Expression],
        derived: Sequence[Derived],
        bindings: Mapping[str, Binding],
        codes: Sequence[CodeGroup] = (),
        updates: Sequence[tuple[CodeUpdate, Sequence[PlacedArgument]]] = (),
    ) -> None:
        self._store = store
        self.bindings = bindings
        self.derived = derived
        self._codes = codes
        self._checked = -1
        self._optional = [
            residual
            for residual in derived
            if residual.reads.optionals or residual.reads.guard_optionals
        ]
        self.rows_version = 0
        self.tables: dict[str, Any] = dict(store.tables)
        tables: list[Table] = list(layout.tables)
        entities: list[Entity] = list(layout.entities)
        for owner in owners:
            state = state_of(owner)
            if state is None:
                continue
            path = parameter_table(owner.label)
            columns = owner.parameters.columns
            tables.append(Table(path, "parameters", "list", "", path, owner.label, columns))
            entities.append(state.entity)
            self.tables[path] = ParameterTable(owner.parameters)
        number = {(e.table, e.prefix): k for k, e in enumerate(entities)}
        groups: list[Group] = list(layout.groups)
        self.programs: list[Program | GroupKernel | None] = [None] * len(groups)
        for residual in derived:
            tables.append(residual.table)
            self.tables[residual.table.path] = residual.rows
            group = residual.kernel.group
            uses = tuple(Use(use.slot, number[residual.entities[use.entity]]) for use in group.uses)
            groups.append(msgspec.structs.replace(group, uses=uses))
            self.programs.append(residual.compiled or residual.program)
        self.hooks: dict[int, Callable[[], CodeHook]] = {}
        for code in codes:
            tables.append(code.table)
            self.tables[code.table.path] = code.rows
            uses = tuple(Use(u.slot, number[code.entities[u.entity]]) for u in code.group.uses)
            self.hooks[len(groups)] = partial(CodeHook, code.code, code.placed)
            groups.append(msgspec.structs.replace(code.group, uses=uses))
            self.programs.append(code.program)
        self.updates = [
            UpdateHook(update, [(number[p.entity.table, p.entity.prefix], p) for p in placed])
            for update, placed in updates
        ]
        self.layout = msgspec.structs.replace(
            layout, tables=tuple(tables), entities=tuple(entities), groups=tuple(groups)
        )

    @property
    def structure_version(self) -> tuple[int, int]:
        """Changes whenever rows or refs of the model or of the residuals change."""
        return self._store.structure_version, self.rows_version

    def check(self) -> None:
        """Check that all rows and values that are read exist.

        Raises
        ------
        AraelError
            E0765 a removed row, or an absent optional.
        """
        if self._checked != self._store.structure_version:
            for residual in self.derived:
                self._check_rows(residual)
            for code in self._codes:
                self._check_code(code)
            self._checked = self._store.structure_version
        for residual in self._optional:
            self._check_optionals(residual)

    def _check_rows(self, derived: Derived) -> None:
        for path, refs in derived.reads.refs.items():
            if refs is not None and (derived.rows.target_rows(path) < 0).any():
                raise AraelError(
                    Diagnostic(
                        "E0765",
                        f"`{derived.residual.label}` reads `{path}`, which was removed",
                        derived.residual.span,
                        help=("remove the residual, or add it again with an existing row",),
                    )
                )

    def _check_code(self, group: CodeGroup) -> None:
        for place in group.placed:
            refs = place.argument.refs
            if refs is not None and (refs.rows < 0).any():
                at = int(np.argmax(refs.rows < 0))
                raise AraelError(
                    Diagnostic(
                        "E0765",
                        f"`{group.code.label}` reads `{place.argument.name}` of a row that was "
                        f"removed, in instance {at}",
                        origin=group.code.label,
                        help=("remove the residuals, or add them again with existing rows",),
                    )
                )

    def _check_optionals(self, derived: Derived) -> None:
        """Check that untested optionals are present in the active rows of formulas."""
        every = np.arange(derived.rows.size)
        self._check_there(derived, derived.reads.guard_optionals, every)
        group = derived.kernel.group
        if derived.reads.optionals:
            rows = every if group.guard is None else active_rows(self, group, self._natives())
            self._check_there(derived, derived.reads.optionals, rows)

    def _natives(self) -> NativeTable:
        bindings = {**self._store.bindings, **self.bindings}
        return NativeTable([f for f in self.layout.functions if f.native], bindings)

    def _check_there(self, derived: Derived, optionals: Unproved, at: NDArray[np.int64]) -> None:
        walker = Walker(self, derived.table.path, at)
        for (steps, table, within), span in optionals.items():
            rows = walker.rows(Slot(steps, table))
            present = self.tables[table].present(within)
            # A null ref on the path is reported separately.
            if (rows >= 0).all() and not present[rows].all():
                raise AraelError(
                    Diagnostic(
                        "E0765",
                        f"`{span.text}` is absent",
                        span,
                        label=f"`{within}` is optional, and absent in this row",
                        help=(
                            "set it before solving, or give the residual a guard, "
                            '`when="..."`, that tests it',
                        ),
                    )
                )
