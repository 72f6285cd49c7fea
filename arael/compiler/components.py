"""Components in the state of their entity: updates after a step, and values computed of a row."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from arael.check.typed import ComponentSite, Read, Typed
from arael.compiler.scalarise import Calls, Nodes, Scalariser
from arael.diagnostics.records import Span
from arael.runtime.layout import ParamUse
from arael.symbolic.graph import Graph
from arael.symbolic.parameters import parameter_type

CARRIED = "carried"
"""Kind of the use of a column that a component carries along."""


class _NoUses:
    """All that a component reads is in its own row."""

    def stored(self, slot: int, column: str) -> Sequence[tuple[int, int]]:
        raise AssertionError(column)

    def cached(self, slot: int, column: str, cache: str) -> Sequence[tuple[int, int]]:
        raise AssertionError(column)


class _RowScalariser(Scalariser):
    """Scalarises what reads the row at hand: `row` has the nodes of each column."""

    def __init__(
        self, graph: Graph, row: Mapping[str, Nodes], computed: Mapping[str, Typed], calls: Calls
    ) -> None:
        super().__init__(graph, _NoUses(), calls)
        self.row = row
        self.computed = computed

    def _read(self, e: Read) -> Nodes:
        if e.version == "computed":
            return self.nodes(self.computed[e.column])
        return self.row[e.column]

    def _state(self, read: Read, cache: str) -> Nodes:
        return parameter_type(read.parameter).caches(self.graph, self.row[read.column])[cache]

    def _place(self, span: Span) -> int | None:
        return self.graph.place


def updated(
    graph: Graph,
    uses: Sequence[ParamUse],
    stored: Sequence[int],
    step: Sequence[int],
    components: Sequence[ComponentSite],
    calls: Calls,
) -> Nodes:
    """Stored scalars after the updates of those components that the step moves.

    A step of zero moves nothing, so states can be refreshed, and rows held, without an update.
    """
    row = _row(uses, stored)
    formulas = _formulas(components)
    by_column = {use.column: use for use in uses}
    for component in components:
        if not component.updates:
            continue
        before = dict(row)
        for assignment in component.updates:
            # A scalariser each: the next one reads what this one has set.
            value = _RowScalariser(graph, row, formulas, calls).nodes(assignment.value)
            count = len(row[assignment.column])
            row[assignment.column] = list(value) * (count if len(value) == 1 else 1)
        moved = _moved(graph, [by_column[column] for column in component.moved], step)
        for column, after in row.items():
            if after is not before[column]:
                row[column] = [
                    a if a == b else graph.op("select", moved, a, b)
                    for a, b in zip(after, before[column], strict=True)
                ]
    return [node for use in uses for node in row[use.column]]


def computed(
    graph: Graph,
    uses: Sequence[ParamUse],
    stored: Sequence[int],
    components: Sequence[ComponentSite],
    calls: Calls,
) -> dict[str, Nodes]:
    """Values of the ``compute`` fields, by path, of the stored scalars after updates."""
    formulas = _formulas(components)
    row = _RowScalariser(graph, _row(uses, stored), formulas, calls)
    return {column: row.nodes(value) for column, value in formulas.items()}


def _row(uses: Sequence[ParamUse], stored: Sequence[int]) -> dict[str, Nodes]:
    return {u.column: list(stored[u.stored_start : u.stored_start + u.stored]) for u in uses}


def _formulas(components: Sequence[ComponentSite]) -> dict[str, Typed]:
    return {one.column: one.value for component in components for one in component.computed}


def _moved(graph: Graph, uses: Sequence[ParamUse], step: Sequence[int]) -> int:
    """Whether the step changes one of the parameters; true of a step that is not a number."""
    zero = graph.const(0.0)
    found: int | None = None
    for use in uses:
        for scalar in step[use.tangent_start : use.tangent_start + use.tangent]:
            moves = graph.op("ne", scalar, zero)
            found = moves if found is None else graph.op("or", found, moves)
    assert found is not None, "a component has a parameter"
    return found
