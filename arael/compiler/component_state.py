"""Components in the state of their entity: updates after a step, and values of formulas.

Stored values of a component are stored like parameters without a tangent. A step is applied in this
order: parameters are retracted, updates are performed, then caches and formulas of the state are
computed from the new stored scalars.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Literal

from arael.check.typed import (
    BOOL,
    ComponentSite,
    Definition,
    Formula,
    MatrixType,
    Read,
    ScalarType,
    Typed,
)
from arael.compiler.scalarise import Calls, Nodes, NoUses, Scalariser, width
from arael.diagnostics.records import Span
from arael.manifolds.parameters import parameter_type
from arael.runtime import layout
from arael.runtime.layout import Param, ParamUse
from arael.runtime.machine.tape import Tape
from arael.symbolic.graph import Graph

CARRIED: Literal["carried"] = "carried"
"""Kind of the use of a column that a component carries along."""

Row = dict[str, Nodes]
"""Nodes of the scalars of each column of a row."""


class RowScalariser(Scalariser):
    """Scalarises what reads the row at hand.

    Parameters
    ----------
    row : nodes of each column, and of formulas that are kept
    calls : functions with prescribed derivatives
    computed : formulas of ``compute`` fields that are not in `row`
    cache : nodes of a cached value of a parameter, where the state holds it
    """

    def __init__(
        self,
        graph: Graph,
        row: Mapping[str, Nodes],
        calls: Calls,
        computed: Mapping[str, Typed] | None = None,
        cache: Callable[[Read, str], Nodes] | None = None,
    ) -> None:
        super().__init__(graph, NoUses(), calls)
        self.row = row
        self.computed = computed or {}
        self.cache = cache or self._derived

    def _read(self, e: Read) -> Nodes:
        node = self.row.get(e.column)
        return self.nodes(self.computed[e.column]) if node is None else list(node)

    def _formula(self, e: Formula) -> Nodes:
        node = self.row.get(e.column)
        return self.nodes(e.of) if node is None else list(node)

    def _state(self, read: Read, cache: str) -> Nodes:
        return self.cache(read, cache)

    def _derived(self, read: Read, cache: str) -> Nodes:
        return parameter_type(read.parameter).caches(self.graph, self.row[read.column])[cache]

    def _place(self, span: Span) -> int | None:
        return self.graph.place


def set_by_updates(components: Sequence[ComponentSite]) -> frozenset[str]:
    """Columns that some update assigns to."""
    return frozenset(a.column for component in components for a in component.updates)


def updated(
    graph: Graph,
    row: Row,
    step: Mapping[str, Sequence[int]],
    bounds: Mapping[str, Param],
    components: Sequence[ComponentSite],
    calls: Calls,
) -> Row:
    """The row after the updates of those components that the step moves.

    A step of zero moves nothing, so states can be refreshed, and rows held, without an update.

    Parameters
    ----------
    row : stored scalars of each column, the step taken already
    step : the step of each parameter
    bounds : what is known of each parameter; what an update sets is kept within its bounds
    """
    row = dict(row)
    formulas = _formulas(components)
    for component in components:
        before = dict(row)
        for assignment in component.updates:
            # A scalariser each: the next one reads what this one has set.
            value = RowScalariser(graph, row, calls, formulas).nodes(assignment.value)
            count = len(row[assignment.column])
            value = list(value) * (count if len(value) == 1 else 1)
            if assignment.column in bounds:
                value = _within(graph, value, bounds[assignment.column])
            row[assignment.column] = value
        if not component.updates:
            continue
        moved = _moved(graph, [step[column] for column in component.moved])
        for column, after in row.items():
            if after is not before[column]:
                row[column] = [
                    a if a == b else graph.op("select", moved, a, b)
                    for a, b in zip(after, before[column], strict=True)
                ]
    return row


def computed(
    graph: Graph,
    row: Row,
    cache: Callable[[Read, str], Nodes],
    components: Sequence[ComponentSite],
    calls: Calls,
) -> Row:
    """Values of the ``compute`` fields, by path, of the row as updates have left it."""
    formulas = _formulas(components)
    scalariser = RowScalariser(graph, row, calls, formulas, cache)
    return {column: scalariser.nodes(value) for column, value in formulas.items()}


def given(
    uses: Sequence[ParamUse], components: Sequence[ComponentSite], calls: Calls
) -> tuple[tuple[layout.Formula, ...], Tape | None]:
    """All formulas as a program over the stored scalars, for those who read them from Python.

    Those that need native code are left out.
    """
    graph = Graph()
    row = {u.column: [graph.input(u.stored_start + k) for k in range(u.stored)] for u in uses}
    scalariser = RowScalariser(graph, row, calls, _formulas(components))
    formulas: list[layout.Formula] = []
    outputs: Nodes = []
    for component in components:
        for definition in (*component.symbolic, *component.computed):
            nodes = scalariser.nodes(definition.value)
            if not needs_native(graph, nodes):
                kind: Literal["real", "bool"] = "bool" if definition.value.type == BOOL else "real"
                formulas.append(
                    layout.Formula(definition.column, kind, shape(definition.value), len(outputs))
                )
                outputs += nodes
    if not formulas:
        return (), None
    return tuple(formulas), graph.tape(outputs, inputs=range(sum(u.stored for u in uses)))


def needs_native(graph: Graph, nodes: Sequence[int]) -> bool:
    """Whether a value comes from native code, or a derivative of it does."""
    calls = (graph.functions.get(graph.ops[n]) for n in graph.live(nodes))
    return any(f is not None and f.native for f in calls)


def shape(value: Typed) -> tuple[int, ...]:
    """Shape of the values of an expression as Python sees it."""
    if isinstance(value.type, MatrixType):
        return (value.type.rows, value.type.columns)
    return () if isinstance(value.type, ScalarType) else (width(value.type),)


def names_of(definition: Definition, prefix: str) -> list[str]:
    """Names of the scalars of a formula: ``u.dir.x``, ``u.R[0,2]``."""
    name, size = definition.column.removeprefix(prefix), shape(definition.value)
    if len(size) == 2:
        return [f"{name}[{r},{c}]" for r in range(size[0]) for c in range(size[1])]
    if not size:
        return [name]
    if size[0] <= 3:
        return [f"{name}.{axis}" for axis in "xyz"[: size[0]]]
    return [f"{name}[{k}]" for k in range(size[0])]


def _formulas(components: Sequence[ComponentSite]) -> dict[str, Typed]:
    return {
        definition.column: definition.value
        for component in components
        for definition in component.computed
    }


def _within(graph: Graph, value: Nodes, param: Param) -> Nodes:
    parts = list(value)
    for name, ends in (("max", param.low), ("min", param.high)):
        for k, end in enumerate(ends):
            if end is not None:
                parts[k] = graph.op(name, parts[k], graph.const(end))
    return parts


def _moved(graph: Graph, steps: Sequence[Sequence[int]]) -> int:
    """Whether one of these steps is not zero; true of a step that is not a number."""
    zero = graph.const(0.0)
    total: int | None = None
    for step in steps:
        for scalar in step:
            moves = graph.op("ne", scalar, zero)
            total = moves if total is None else graph.op("or", total, moves)
    assert total is not None, "a component has a parameter"
    return total
