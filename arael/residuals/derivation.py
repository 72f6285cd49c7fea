"""From the text of a residual to its program: resolved, differentiated, assembled."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from arael.check.binding import Broken
from arael.check.expressions import condition
from arael.check.guards import Fact, facts_of, moves
from arael.check.losses import loss_of
from arael.check.report import Reporter
from arael.check.requirements import Requirement, is_requirement, requirement_of
from arael.check.residual_rows import residual_of
from arael.check.typed import ConstraintSite, EntitySite, Present, Read, Typed
from arael.check.walk import postorder
from arael.compiler.entities import StateModel, model_state
from arael.compiler.groups import Kernel, compile_constraint
from arael.diagnostics.records import Findings, Label
from arael.residuals.declared import Declared
from arael.residuals.expression import Expression, RuntimeResidual
from arael.residuals.messages import error
from arael.residuals.parameters import parameter_table
from arael.residuals.reader import FormulaReads, Reader, Surroundings
from arael.residuals.resolution import reader_for
from arael.residuals.rows import RowsTable
from arael.runtime.evaluation.group_kernel import GroupKernel
from arael.runtime.layout import Entity, Table
from arael.runtime.machine.compiled import Program


@dataclass
class Derived:
    """A derived residual.

    Attributes
    ----------
    residual : its text and data
    reads : what its formula and guard read
    kernel : its group, with entities numbered as in `entities`
    entities : (table, prefix) of each entity that it reads
    states : these entities
    site, models : what `kernel` is derived from
    program : program of the expression machine
    rows : data and refs, a row for each instance
    table : the layout of these rows
    compiled : the kernel used in its place, after `compile`
    """

    residual: RuntimeResidual
    reads: FormulaReads
    kernel: Kernel
    entities: tuple[tuple[str, str], ...]
    states: tuple[Entity, ...]
    program: Program
    rows: RowsTable
    table: Table
    site: ConstraintSite
    models: tuple[StateModel, ...]
    compiled: GroupKernel | None = None


def state_of(expression: Expression) -> StateModel | None:
    """The entity of a residual's own parameters; None if it has none."""
    columns = expression.parameters.columns
    if not columns:
        return None
    return model_state(EntitySite("parameters", parameter_table(expression.label), "", columns))


def derive(
    residual: RuntimeResidual,
    around: Surroundings,
    owners: Sequence[Expression],
    declared: Declared,
    natives: Sequence[str],
    constant_too: bool = False,
) -> Derived:
    """Resolve, check and differentiate one residual.

    Parameters
    ----------
    around : its scope
    owners : expressions with parameters, those of the residual itself included
    declared : functions and constants that it may use
    natives : names of native functions, in the order in which the runtime numbers them
    constant_too : whether it may have no parameter, as for a value that is only read

    Raises
    ------
    AraelError
        With all mistakes of the text and their places.
    """
    findings = Findings()
    report = Reporter(findings)
    path = f"{parameter_table(residual.label)}/rows"
    reader = reader_for(
        residual, path, around, declared.declarations, report, declared.constants.named
    )
    formula_reads = reader.reads
    guard = _guard_of(reader, residual)
    proved = frozenset() if guard is None else facts_of(guard, reader.slots.steps)[0]
    with reader.knowing(proved):
        loss = None if residual._loss_tree is None else loss_of(reader, residual._loss_tree)
        required: Requirement | None = None
        if is_requirement(residual._tree):
            required = requirement_of(reader, residual._tree)
            typed = None if required is None else [*required.rows]
        else:
            typed = residual_of(reader, residual._tree)
    report.stop()
    assert typed is not None
    if required is not None and loss is not None:
        raise error(
            "E0760",
            "what must hold takes no loss",
            residual.label,
            "leave `loss` out, or write the difference of both sides as a residual",
        )
    _check_rows(reader, [*typed, *([] if loss is None else [loss.value])], proved)
    report.stop()
    reads = [n for n in postorder(typed) if isinstance(n, Read)]
    moves = any(n.version == "trial" and n.parameter for n in reads)
    if not moves and not constant_too:
        stored = [n for n in postorder(typed) if isinstance(n, Read) and n.version == "stored"]
        reader.fail(
            "E0601",
            residual.span,
            "the residual has no parameter",
            label="it cannot change",
            labels=[Label(n.span, "the stored value does not move") for n in stored[:3]],
            help=["name the unknowns, or pass them in `parameters`"],
        )
        report.stop()
    read = {slot.table for slot in reader.slots.items}
    states = [s for s in around.schema.states if s.entity.table in read]
    for owner in owners:
        if parameter_table(owner.label) in read:
            state = state_of(owner)
            assert state is not None
            states.append(state)
    site = ConstraintSite(
        label=residual.label,
        struct="residuals",
        name=residual.label,
        table=path,
        prefix="",
        span=residual.span,
        slots=tuple(reader.slots.items),
        residual=tuple(typed),
        guard=guard,
        loss=loss,
        require="" if required is None else required.sense,
        require_text=" ".join(residual.text.split()) if required else "",
        units=() if required is None else required.units,
    )
    single = around.schema.layout.precision == "f32"
    kernel = compile_constraint(site, states, single, declared.functions)
    entities = tuple((s.entity.table, s.entity.prefix) for s in states)
    table = Table(
        path=path,
        struct="residuals",
        collection="list",
        parent="",
        field=path,
        where=residual.label,
        columns=tuple(formula_reads.columns.values()),
    )
    return Derived(
        residual,
        formula_reads,
        kernel,
        entities,
        tuple(s.entity for s in states),
        Program(kernel.group, [s.entity for s in states], single, natives),
        RowsTable(residual.label, formula_reads.data, formula_reads.refs),
        table,
        site,
        tuple(states),
    )


def _guard_of(t: Reader, residual: RuntimeResidual) -> Typed | None:
    """The guard of a residual; None without one, or after an error."""
    if residual._when_tree is None:
        return None
    guard = condition(t, residual._when_tree)
    t.reads.guard_optionals, t.reads.optionals = t.reads.optionals, {}
    if isinstance(guard, Broken):
        return None
    if moves(guard):
        t.fail(
            "E0766",
            guard.span,
            "the guard of a runtime residual reads a parameter",
            label="changes during the solve",
            help=["write `if ... then ... else 0` in the formula"],
        )
        return None
    return guard


def _check_rows(t: Reader, values: Sequence[Typed], proved: frozenset[Fact]) -> None:
    """Report rows reached through an optional ref that only an `if` tests, as in a model file."""
    for node in postorder(values):
        if not isinstance(node, Read | Present):
            continue
        needs: Any = t.slots.needs.get(node.slot, ())
        for source, column in needs:
            key = (source.steps, source.table, column)
            if (source.steps, column) not in proved and key not in t.reads.optionals:
                t.fail(
                    "E0503",
                    node.span,
                    f"the row that `{column}` points to may be absent here",
                    label=f"`when` does not test `{column}`",
                    notes=["a row of a residual is active only if all rows that it reads exist"],
                    help=['give the residual a guard, `when="..."`, and add another for the rest'],
                )
                return
