"""Sums over the rows of a list whose terms do not separate into data of a row and parameters.

Such a sum is evaluated term by term, for as many rows as a list has. A constraint is divided into
the residuals, which read the sums as inputs, and one program for each term, which is the same for
all rows. Each is differentiated by itself. The runtime joins them by the chain rule for the lengths
that the data has (`arael.runtime.unrolled`); the group itself is for lists without rows.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from arael.check import typed
from arael.check.typed import ConstraintSite
from arael.compiler.bounded import BoundedGraph
from arael.compiler.hoisting import hoist
from arael.compiler.moving_guards import LANE
from arael.compiler.scalarise import Nodes, RawInput, StateInput
from arael.diagnostics.records import AraelError, Diagnostic
from arael.runtime.layout import Piece, Raw, RowSums, Use
from arael.symbolic.graph import Graph
from arael.symbolic.jacobian import jacobian as differentiate

Seeds = dict[int, dict[tuple[int, int], int]]


class SumInput(NamedTuple):
    """A component of a sum over rows of the row at slot `owner`, as an input of what reads it."""

    sum: int
    component: int
    owner: int


@dataclass(frozen=True)
class RowSum:
    """A sum that is evaluated term by term.

    Attributes
    ----------
    total : the sum
    terms : nodes of the scalars of its term
    """

    total: typed.Total
    terms: Nodes


@dataclass(frozen=True)
class Divided:
    """A constraint with sums over rows.

    Attributes
    ----------
    graph : of all nodes
    uses : entities that it reads, those of rows included
    residuals : nodes, which read sums as inputs
    holds : node of the guard over parameters, or None
    sums : in order; a term may read those before it
    seeds : derivatives of the inputs that some nodes read, by use and tangent scalar
    """

    graph: Graph
    uses: Sequence[Use]
    residuals: list[int]
    holds: int | None
    sums: Sequence[RowSum]
    seeds: Callable[[Graph, list[int]], Seeds]


def require_flat(site: ConstraintSite, graph: Graph, total: typed.Total, terms: Nodes) -> None:
    """Refuse a term that contains a sum over rows of its own that is evaluated term by term.

    Raises
    ------
    AraelError
        E0621
    """
    steps = site.slots[total.rows].steps
    for node in graph.live(terms):
        key = graph.key(node) if graph.ops[node] == "input" else None
        if isinstance(key, SumInput) and site.slots[key.owner].steps[: len(steps)] == steps:
            raise AraelError(
                Diagnostic(
                    "E0621",
                    "a sum over rows within a sum over rows is no sum of products of row data "
                    "and parameters",
                    total.span,
                    "its term has a sum over rows of its own",
                    notes=(
                        "the inner sum is formed before a solve if its term is a sum of products "
                        "of row data and parameters",
                    ),
                    help=(
                        "let the inner list be one of refs of fixed length, or the inner sum a "
                        "parameter of its row that a constraint there sets equal to it",
                    ),
                )
            )


def divide(site: ConstraintSite, whole: Divided) -> RowSums:
    """The programs of a constraint with sums over rows, and what they read."""
    return _Division(site, whole).result()


class _Division:
    def __init__(self, site: ConstraintSite, whole: Divided) -> None:
        self.site, self.whole, self.graph = site, whole, whole.graph
        lists: dict[tuple[int, int], None] = {}
        for row_sum in whole.sums:
            lists[row_sum.total.slot, row_sum.total.rows] = None
        self.lists = tuple(lists)
        self.own_list = [self.lists.index((o.total.slot, o.total.rows)) for o in whole.sums]

    def result(self) -> RowSums:
        graph, whole = self.graph, self.whole
        jacobians = [self._jacobian(nodes) for nodes in self._values()]
        guard = [] if whole.holds is None else [whole.holds]
        outputs = [n for nodes in self._values() for n in nodes] + guard
        outputs += [node for jacobian in jacobians for node in jacobian.values()]
        live = graph.live(outputs)
        keys = [graph.key(n) for n in live if graph.ops[n] == "input"]
        raw_keys = sorted(k for k in keys if isinstance(k, RawInput))
        moving = {graph.input(k) for k in keys if not isinstance(k, RawInput)}
        lanes, uniforms = hoist(self.site, graph, outputs, live, moving, raw_keys)
        self._place(lanes, uniforms, raw_keys)
        main, *terms = (
            self._piece(nodes, jacobian)
            for nodes, jacobian in zip(self._values(), jacobians, strict=True)
        )
        prepares = [self._prepare(self.of_list[k], []) for k in range(len(self.lists))]
        raw, prepare = self._prepare(self.own, uniforms)
        return RowSums(
            slots=self.site.slots,
            uses=tuple(whole.uses),
            lists=self.lists,
            raw=raw,
            prepare=prepare,
            uniforms=len(uniforms),
            row_raw=tuple(inputs for inputs, _ in prepares),
            row_prepare=tuple(program for _, program in prepares),
            main=main,
            sums=tuple(zip(self.own_list, terms, strict=True)),
            guard=self._piece(guard, {}) if guard else None,
        )

    def _values(self) -> list[list[int]]:
        """Values of each program: residuals, then the terms of each sum."""
        return [self.whole.residuals, *(list(row_sum.terms) for row_sum in self.whole.sums)]

    def _jacobian(self, nodes: list[int]) -> dict[tuple[int, int, int], int]:
        """(value, use, tangent) -> derivative; the use of a sum s is ``-1 - s``."""
        graph = self.graph
        seeds = self.whole.seeds(graph, nodes)
        for node in graph.live(nodes):
            key = graph.key(node) if graph.ops[node] == "input" else None
            if isinstance(key, SumInput):
                seeds[node] = {(-1 - key.sum, key.component): graph.const(1.0)}
        rows = differentiate(graph, nodes, seeds)
        return {(k, *seed): row[seed] for k, row in enumerate(rows) for seed in sorted(row)}

    def _place(self, lanes: list[int], uniforms: list[int], raw_keys: list[RawInput]) -> None:
        """Find out which lane inputs are of rows, and of which list."""
        self.own: list[int] = []
        self.of_list: list[list[int]] = [[] for _ in self.lists]
        below = [
            self.graph.depends(
                {self.graph.input(k) for k in raw_keys if self._is_below(k.slot, rows)}
            )
            for _, rows in self.lists
        ]
        self.input_of: dict[int, tuple[Any, ...]] = {}
        for node in lanes:
            number = next((k for k, nodes in enumerate(below) if node in nodes), -1)
            kept = self.own if number < 0 else self.of_list[number]
            self.input_of[node] = ("lane" if number < 0 else "row", len(kept), 0)
            kept.append(node)
        for k, node in enumerate(uniforms):
            self.input_of[node] = "uniform", k, 0

    def _is_below(self, slot: int, rows: int) -> bool:
        way = self.site.slots[rows].steps
        return self.site.slots[slot].steps[: len(way)] == way

    def _prepare(self, lanes: list[int], uniforms: list[int]) -> tuple[tuple[Raw, ...], Any]:
        """What lane inputs are computed from, and by which program."""
        graph, outputs = self.graph, [*lanes, *uniforms]
        keys = sorted(
            k
            for n in graph.live(outputs)
            if graph.ops[n] == "input" and isinstance(k := graph.key(n), RawInput)
        )
        return tuple(Raw(*key) for key in keys), graph.tape(outputs, inputs=keys)

    def _piece(self, values: list[int], entries: dict[tuple[int, int, int], int]) -> Piece:
        """Values with their derivatives as one program."""
        graph = self.graph
        program = BoundedGraph(self.site.label, self.site.span)
        copies: dict[int, int] = {}
        for node in graph.live([*values, *entries.values()]):
            key = graph.key(node) if graph.ops[node] == "input" else None
            if node in self.input_of:
                copies[node] = program.input(self.input_of[node])
            elif isinstance(key, StateInput):
                copies[node] = program.input(("state", key.use, key.offset))
            elif isinstance(key, SumInput):
                copies[node] = program.input(("sum", key.sum, key.component))
            elif key == LANE:
                copies[node] = program.input(("guard", 0, 0))
        moved = graph.copy([*values, *entries.values()], program, copies)
        entries_of = dict(zip(entries, moved[len(values) :], strict=True))
        zero = program.const(0.0)
        entries_of = {where: node for where, node in entries_of.items() if node != zero}
        outputs = [*moved[: len(values)], *entries_of.values()]
        live = set(program.live(outputs))
        inputs: list[Hashable] = [k for k in program.inputs if program.input(k) in live]
        return Piece(
            inputs=tuple(inputs),  # type: ignore[arg-type]
            tape=program.tape(outputs, inputs=inputs),
            values=len(values),
            entries=tuple(entries_of),
        )


def without_rows(
    site: ConstraintSite, whole: Divided
) -> tuple[Graph, list[Use], list[int], int | None]:
    """The constraint for lists without rows, whose sums are zero: graph, uses, residuals, guard."""
    graph = whole.graph
    outputs = [*whole.residuals, *([] if whole.holds is None else [whole.holds])]
    kept = BoundedGraph(site.label, site.span)
    known = _zeros(graph, outputs, kept)
    live = [graph.key(n) for n in graph.live(outputs) if graph.ops[n] == "input"]
    numbers = sorted({key.use for key in live if isinstance(key, StateInput)})
    for key in live:
        if isinstance(key, StateInput):
            moved = StateInput(numbers.index(key.use), key.offset)
            known[graph.input(key)] = kept.input(moved)
    nodes = graph.copy(outputs, kept, known)
    holds = None if whole.holds is None else nodes.pop()
    return kept, [whole.uses[k] for k in numbers], nodes, holds


def _zeros(graph: Graph, outputs: Iterable[int], target: Graph) -> dict[int, int]:
    """The inputs of `outputs` that are sums, and zero in their place."""
    zero = target.const(0.0)
    return {
        node: zero
        for node in graph.live(outputs)
        if graph.ops[node] == "input" and isinstance(graph.key(node), SumInput)
    }
