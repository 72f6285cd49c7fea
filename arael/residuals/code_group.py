"""From residuals by own code to a group: slots, uses, and the tape behind the function's results.

The function's residuals and Jacobian entries are lane data of the group. The tape multiplies
Jacobians in ambient coordinates by the derivatives of the stored scalars by a step, and applies the
loss by the formula that the compiler uses. So cost, gradient and blocks are those of the same
residual written in the language.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from arael.check.losses import loss_of
from arael.check.report import Reporter
from arael.check.typed import Loss, Read
from arael.check.walk import postorder
from arael.compiler.bounded import BoundedGraph
from arael.compiler.entities import StateModel, see_inputs
from arael.compiler.lead import leading
from arael.compiler.losses import robust_rows
from arael.compiler.scalarise import RawInput, StateInput
from arael.diagnostics.records import Findings, Source, Span
from arael.residuals.code import LARGEST, CodeResidual
from arael.residuals.code_arguments import Argument, PlacedArgument
from arael.residuals.declared import Declared
from arael.residuals.expression import RuntimeResidual
from arael.residuals.messages import error
from arael.residuals.parameters import parameter_table
from arael.residuals.reader import Surroundings
from arael.residuals.resolution import reader_for
from arael.residuals.rows import RowsTable
from arael.runtime.layout import Column, Group, Slot, Step, Table, Target, Use
from arael.runtime.machine.compiled import Program
from arael.runtime.machine.tape import Tape

_SIGNS = {"equal": "==", "at_least": ">="}


@dataclass
class CodeGroup:
    """Residuals by own code as a group over a table of its own.

    Attributes
    ----------
    group : with entities numbered as in `entities`
    entities : (table, prefix) of each entity that it reads
    placed : its arguments in these
    """

    code: CodeResidual
    group: Group
    entities: tuple[tuple[str, str], ...]
    placed: tuple[PlacedArgument, ...]
    program: Program
    rows: CodeRows
    table: Table


class CodeRows(RowsTable):
    """Rows of residuals by own code: one for each instance, with refs to the rows it reads."""

    def __init__(self, code: CodeResidual, refs: Mapping[str, Any]) -> None:
        self._code = code
        super().__init__(code.label, {}, refs)

    def refresh(self) -> None:
        """Take the number of instances, which data may determine."""
        self.data_version += 1
        if self.size != self._code.count:
            self.size = self._code.count
            self.structure_version += 1

    def row_name(self, row: int) -> str:
        """Name of an instance with its parameters: ``near[3] of poses[3].pos, poses[4].pos``."""
        names = ", ".join(argument.name_at(row) for argument in self._code.arguments)
        return f"{super().row_name(row)} of {names}"


def group_of(
    code: CodeResidual, around: Surroundings, states: Sequence[StateModel], declared: Declared
) -> CodeGroup:
    """Make the group of `code`.

    Raises
    ------
    AraelError
        E0770: a parameter that is not solved for, or a Jacobian of too many entries; mistakes of
        the text of the loss.
    """
    path = f"{parameter_table(code.label)}/rows"
    slots: list[Slot] = [Slot((), path)]
    refs: dict[str, Any] = {}
    columns: list[Column] = []
    uses: list[Use] = []
    owners: list[Argument] = []
    entities: list[tuple[str, str]] = []
    models: list[StateModel] = []
    at_uses: list[int] = []
    for argument in code.arguments:
        state = _state(states, argument, code.label)
        key = state.entity.table, state.entity.prefix
        if key not in entities:
            entities.append(key)
            models.append(state)
        number = entities.index(key)
        use = next(
            (
                u
                for u, known in enumerate(uses)
                if known.entity == number and owners[u].same_rows(argument)
            ),
            None,
        )
        if use is None:
            use = len(uses)
            slots.append(_slot(argument, use, refs, columns))
            uses.append(Use(len(slots) - 1, number))
            owners.append(argument)
        at_uses.append(use)
    placed = placed_of(code.arguments, states, code.label, at_uses)
    loss = _loss(code, path, around, declared)
    single = around.schema.layout.precision == "f32"
    tape, states_read, entries, count = _tape(code, placed, models, uses, loss, declared, single)
    group = Group(
        label=code.label,
        struct="residuals",
        constraint=code.label,
        where=code.label,
        table=path,
        prefix="",
        residuals=code.size,
        slots=tuple(slots),
        uses=tuple(uses),
        raw=(),
        prepare=Tape(("const",), ((0,),), (0.0,), (0,) * count),
        data_count=count,
        uniform_count=0,
        states=states_read,
        tape=tape,
        jacobian=entries,
        places=(),
        lead=leading(
            uses, slots, [m.entity.table for m in models], [m.entity.tangent for m in models]
        ),
        loss_text=code.loss or "",
        require="" if code.kind == "cost" else code.kind,  # type: ignore[arg-type]
        require_text="" if code.kind == "cost" else f"{code.label} {_SIGNS[code.kind]} 0",
        units=("",) * code.size if code.kind != "cost" else (),
    )
    table = Table(path, "residuals", "list", "", path, code.label, tuple(columns))
    return CodeGroup(
        code,
        group,
        tuple(entities),
        tuple(placed),
        Program(group, [m.entity for m in models], single),
        CodeRows(code, refs),
        table,
    )


def placed_of(
    arguments: Sequence[Argument],
    states: Sequence[StateModel],
    label: str,
    uses: Sequence[int] | None = None,
) -> tuple[PlacedArgument, ...]:
    """The arguments in their entities.

    Raises
    ------
    AraelError
        E0770: a parameter that is never solved for.
    """
    placed = []
    for k, argument in enumerate(arguments):
        state = _state(states, argument, label)
        at = state.stored_at[argument.column]
        first = at.tangent_start
        placed.append(
            PlacedArgument(
                argument,
                k if uses is None else uses[k],
                state.entity,
                at.stored_start,
                at.stored,
                first,
                at.tangent,
                at.kind,
                state.entity.tangent_names[first : first + at.tangent],
            )
        )
    return tuple(placed)


def _state(states: Sequence[StateModel], argument: Argument, label: str) -> StateModel:
    for state in states:
        if state.entity.table == argument.table and argument.column in state.stored_at:
            if state.stored_at[argument.column].tangent:
                return state
            break
    raise error("E0770", f"`{argument.name}` is never solved for", label)


def _slot(argument: Argument, use: int, refs: dict[str, Any], columns: list[Column]) -> Slot:
    if argument.refs is None:
        return Slot((Step("root"),), "")
    name = f"rows_{use}"
    target = Target(argument.table, "", (), name)
    columns.append(Column(name, "int", (), "ref", "ref", name, target=target))
    refs[name] = argument.refs
    return Slot((Step("ref", name),), argument.table)


def _loss(code: CodeResidual, path: str, around: Surroundings, declared: Declared) -> Loss | None:
    """The loss as typed by the rules of the language; its scale is a constant."""
    if code.loss is None:
        return None
    report = Reporter(Findings())
    text = RuntimeResidual("0", code.label, loss=code.loss)
    reader = reader_for(text, path, around, declared.declarations, report, declared.constants.named)
    assert text._loss_tree is not None
    loss = loss_of(reader, text._loss_tree)
    report.stop()
    assert loss is not None
    if any(isinstance(node, Read) for node in postorder([loss.value])):
        raise error(
            "E0770",
            f"the scale of the loss `{code.loss}` is not a constant",
            code.label,
            "write a number, or apply the loss within the function",
        )
    return loss


def _tape(
    code: CodeResidual,
    placed: Sequence[PlacedArgument],
    models: Sequence[StateModel],
    uses: Sequence[Use],
    loss: Loss | None,
    declared: Declared,
    single: bool,
) -> tuple[Tape, tuple[tuple[int, int], ...], tuple[tuple[int, int, int], ...], int]:
    """The tape, the state scalars and entries (residual, use, tangent) it has, its data inputs."""
    source = Source(code.label, "")
    graph = BoundedGraph(code.label, Span(source, 0, 0))
    ambient = code.coordinates == "ambient"
    widths = [one.stored if ambient else one.tangent for one in placed]
    m, width = code.size, sum(widths)
    if m * width > LARGEST:
        raise error(
            "E0770",
            f"the Jacobian of one instance has {m} x {width} entries",
            code.label,
            f"at most {LARGEST} are possible: divide the residuals among several instances",
        )
    keys = [RawInput(0, "code", k) for k in range(m + m * width)]
    data = [graph.input(key) for key in keys]
    residuals = data[:m]
    seeds: dict[int, dict[tuple[int, int], int]] = {}
    for k, node in enumerate(residuals):
        row = seeds.setdefault(node, {})
        at = m + k * width
        for one, wide in zip(placed, widths, strict=True):
            entries = data[at : at + wide]
            at += wide
            derivatives = _by_step(graph, one, models[uses[one.use].entity], entries, ambient)
            for tangent, value in derivatives.items():
                place = one.use, tangent
                row[place] = graph.op("add", row[place], value) if place in row else value
    rows = [seeds[node] for node in residuals]
    outputs = residuals
    if loss is not None:
        outputs, rows = robust_rows(graph, residuals, seeds, loss, declared.functions, single)
    jacobian_ = {
        (k, use, tangent): row[use, tangent]
        for k, row in enumerate(rows)
        for use, tangent in sorted(row)
    }
    results = [*outputs, *jacobian_.values()]
    live = set(graph.live(results))
    read = sorted(
        key for key in graph.inputs if isinstance(key, StateInput) and graph.input(key) in live
    )
    inputs: list[Hashable] = [*read, *keys]
    tape = graph.tape(results, inputs=inputs)
    return tape, tuple((use, offset) for use, offset in read), tuple(jacobian_), len(keys)


def _by_step(
    graph: BoundedGraph,
    place: PlacedArgument,
    state: StateModel,
    entries: Sequence[int],
    ambient: bool,
) -> dict[int, int]:
    """Derivatives by the tangent scalars of an entity from entries of the function's Jacobian."""
    if not ambient:
        return {place.tangent_start + k: entry for k, entry in enumerate(entries)}
    derivatives: dict[int, int] = {}
    for k, entry in enumerate(entries):
        tangents = state.tangents[place.stored_start + k]
        nodes = list(tangents.values())
        inputs = {
            state.graph.input(o): graph.input(StateInput(place.use, o))
            for o in see_inputs(state.graph, nodes)
        }
        copies = state.graph.copy(nodes, graph, inputs)
        for tangent, node in zip(tangents, copies, strict=True):
            term = graph.op("mul", entry, node)
            derivatives[tangent] = (
                graph.op("add", derivatives[tangent], term) if tangent in derivatives else term
            )
    return derivatives
