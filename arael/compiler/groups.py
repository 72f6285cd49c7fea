"""From a typed constraint to what is evaluated: residuals, derivatives, and what can be done once.

The steps, each a function: scalarise the residual; put its loss into it; differentiate the
straight-line program; hoist what depends on data alone into a program that runs once per solve;
form the products J'J and J'r.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

from msgspec import structs

from arael.check.typed import ConstraintSite, Loss, Typed
from arael.compiler.bounded import BoundedGraph
from arael.compiler.entities import StateModel, see_inputs
from arael.compiler.hoisting import hoist
from arael.compiler.lead import leading
from arael.compiler.look_ups import LookUps, RecordInput
from arael.compiler.losses import robustify
from arael.compiler.moving_guards import LANE, split, switched
from arael.compiler.parts import Parts, cut
from arael.compiler.products import crossed_pairs, many_products, products_of, triplet_pairs
from arael.compiler.row_sums import Divided, SumInput, divide, without_rows
from arael.compiler.scalar_programs import Functions
from arael.compiler.scalarise import Calls, RawInput, Scalariser, StateInput
from arael.compiler.totals import Totals, slots_of_rows
from arael.runtime.layout import Group, Length, Raw, RowSums, Total, Use
from arael.runtime.machine.tape import Tape
from arael.symbolic.graph import Graph
from arael.symbolic.jacobian import derive
from arael.symbolic.jacobian import jacobian as differentiate

if TYPE_CHECKING:
    from arael.symbolic.sharing import Shared

# A constraint that exceeds this, or the limits of `products`, is large: its arithmetic is compiled
# in parts, and its products J'r and J'J are formed by loops over the Jacobian, because the C
# compiler's time grows faster than what a single function gains.
LARGEST_BODY = 1500  # operations of residuals, derivatives and products


@dataclass(frozen=True)
class Kernel:
    """A group and the programs its compiled kernel runs.

    Inputs of `cost` and `linearise` are numbered as in `Group.tape`. Outputs of `cost` are the
    residuals. Outputs of `linearise` are residuals, Jacobian entries, and, unless the constraint is
    large, one gradient entry per `gradient` key (use, tangent) and one product per `products` key
    (use a, use b, row, column). A large constraint has `parts`, those of `linearise`, instead.
    """

    group: Group
    cost: Tape
    linearise: Tape
    gradient: tuple[tuple[int, int], ...]
    products: tuple[tuple[int, int, int, int], ...]
    parts: Parts | None
    state_names: tuple[str, ...]
    data_names: tuple[str, ...]
    uniform_names: tuple[str, ...]


@dataclass(frozen=True)
class Derivatives:
    """Derivatives of a constraint, or of a term of its sums, before they are a program.

    Attributes
    ----------
    title : "" for the residuals
    values : nodes
    shared : their derivatives by (use, tangent), over the graph of the values
    names : of the inputs of that graph, by node
    tangents : names of what is differentiated by
    """

    title: str
    values: list[int]
    shared: Shared[tuple[int, int]]
    names: dict[int, str]
    tangents: dict[tuple[int, int], str]


class _Uses:
    """Numbers the entities that a constraint reads, in order of appearance."""

    def __init__(
        self, site: ConstraintSite, states: Sequence[StateModel], uses: Sequence[Use] = ()
    ) -> None:
        self.site = site
        self.states = states
        self.uses = list(uses)

    def _find(self, slot: int, column: str) -> tuple[int, StateModel]:
        table = self.site.slots[slot].table
        for number, state in enumerate(self.states):
            if state.entity.table == table and column in state.stored_at:
                use = Use(slot, number)
                if use not in self.uses:
                    self.uses.append(use)
                return self.uses.index(use), state
        raise AssertionError(f"no entity for {column} of {table}")

    def stored(self, slot: int, column: str) -> list[tuple[int, int]]:
        use, state = self._find(slot, column)
        at = state.stored_at[column]
        return [(use, at.stored_start + k) for k in range(at.stored)]

    def cached(self, slot: int, column: str, cache: str) -> list[tuple[int, int]]:
        use, state = self._find(slot, column)
        return [(use, offset) for offset in state.caches[column][cache]]

    def formula(self, slot: int, column: str) -> list[tuple[int, int]] | None:
        table = self.site.slots[slot].table
        for state in self.states:
            if state.entity.table == table and column in state.stored_at:
                return self.stored(slot, column)
        return None


def compile_constraint(
    site: ConstraintSite,
    states: Sequence[StateModel],
    single: bool = False,
    functions: Functions | None = None,
) -> Kernel:
    """Derive everything about one constraint at one place, for f32 where `single`.

    If a product of matrices is applied to a vector, the constraint is derived twice, and the
    shorter program is used: factor by factor is shorter for few vectors, the product for many, or
    if the product depends on data alone.
    """
    functions = functions or Functions()
    kernel, chains = _compile(site, states, single, functions, factored=True)
    if chains:
        other, _ = _compile(site, states, single, functions, factored=False)
        if _length(other) <= _length(kernel):
            return other
    return kernel


def _length(kernel: Kernel) -> int:
    """Operations of residuals and derivatives, without the products that large ones leave out."""
    return kernel.group.tape.operations


def _compile(
    site: ConstraintSite,
    states: Sequence[StateModel],
    single: bool,
    functions: Functions,
    factored: bool,
) -> tuple[Kernel, int]:
    """Derive a constraint; return the number of products applied factor by factor, too."""
    scalariser, uses, residuals, guard, holds = _scalarise(
        site, states, single, functions, factored
    )
    graph = scalariser.graph
    assert isinstance(scalariser.totals, Totals)
    assert isinstance(scalariser.look_ups, LookUps)
    row_sums = None
    if scalariser.totals.rows:
        scalariser.look_ups.require_none("a constraint with a sum that is evaluated row by row")
        seeds = partial(_seeds, uses=uses)
        whole = Divided(graph, uses.uses, residuals, holds, scalariser.totals.rows, seeds)
        row_sums = structs.replace(
            divide(site, whole), crossed=crossed_pairs(site, states, uses.uses)
        )
        graph, rows, residuals, holds = without_rows(site, whole)
        uses = _Uses(site, states, rows)
    jacobian = _differentiate(graph, residuals, uses)
    kernel = _assemble(
        site, states, graph, scalariser, uses, residuals, jacobian, guard, holds, row_sums
    )
    return kernel, scalariser.chains


def derivatives(
    site: ConstraintSite,
    states: Sequence[StateModel],
    single: bool = False,
    functions: Functions | None = None,
) -> list[Derivatives]:
    """Derivatives of one constraint as SymPy has them, each section after those that it reads.

    Terms of sums over rows come first, then a guard over parameters, then the residuals. Empty if
    nothing varies.
    """
    scalariser, uses, residuals, _, holds = _scalarise(
        site, states, single, functions or Functions(), factored=True
    )
    graph = scalariser.graph
    assert isinstance(scalariser.totals, Totals)
    sums = {k: graph.input(k) for k in list(graph.inputs) if isinstance(k, SumInput)}
    sections = [
        (
            f"term of sum{k + 1}, over {_slot_name(site, one.total.rows).removesuffix('.')}",
            one.terms,
        )
        for k, one in enumerate(scalariser.totals.rows)
    ]
    sections += [("guard", [holds])] if holds is not None else []
    sections.append(("", residuals))
    derived = []
    for title, values in sections:
        seeds = _seeds(graph, list(values), uses)
        for total, node in sums.items():
            seeds[node] = {(-1 - total.sum, total.component): graph.const(1.0)}
        derived.append((title, list(values), seeds))
    if not any(any(seeds.values()) for _, _, seeds in derived):
        return []
    names: dict[int, str] = {}
    for key in list(graph.inputs):
        node = graph.input(key)
        if isinstance(key, StateInput):
            names[node] = _state_name(site, uses.uses[key.use], states, key.offset)
        elif key == LANE:
            names[node] = "guard"
        elif not isinstance(key, Loss):  # the argument of a loss, replaced by its value
            names[node] = _node_name(site, graph, node)
    tangents = {
        (use, k): f"{_slot_name(site, u.slot)}{states[u.entity].entity.prefix}{name}"
        for use, u in enumerate(uses.uses)
        for k, name in enumerate(states[u.entity].entity.tangent_names)
    }
    for total, node in sums.items():
        tangents[-1 - total.sum, total.component] = names[node]
    return [
        Derivatives(title, values, derive(graph, values, seeds), names, tangents)
        for title, values, seeds in derived
    ]


def _scalarise(
    site: ConstraintSite,
    states: Sequence[StateModel],
    single: bool,
    functions: Functions,
    factored: bool,
) -> tuple[Scalariser, _Uses, list[int], Typed | None, int | None]:
    """Residuals with loss and guard; the guard over data, and the node of that over parameters."""
    graph = BoundedGraph(site.label, site.span)
    uses = _Uses(site, states)
    scalariser = Scalariser(graph, uses, functions, factored)
    scalariser.totals = Totals(graph, site, uses.uses)
    scalariser.look_ups = LookUps(graph, site)
    residuals = [n for part in site.residual for n in scalariser.nodes(part)]
    if site.loss is not None:
        residuals = robustify(scalariser, residuals, site.loss, single)
    guard, moving = split(site.guard)
    holds = None
    if moving is not None:
        (holds,) = scalariser.nodes(moving)
        residuals = switched(graph, residuals)
    return scalariser, uses, residuals, guard, holds


def _differentiate(
    graph: Graph, residuals: list[int], uses: _Uses
) -> dict[tuple[int, int, int], int]:
    """Structurally non-zero Jacobian entries: (residual, use, tangent) -> node."""
    rows = differentiate(graph, residuals, _seeds(graph, residuals, uses))
    zero = graph.const(0.0)
    return {
        (k, use, tangent): row[use, tangent]
        for k, row in enumerate(rows)
        for use, tangent in sorted(row)
        if row[use, tangent] != zero
    }


def _seeds(
    graph: Graph, residuals: list[int], uses: _Uses
) -> dict[int, dict[tuple[int, int], int]]:
    """Derivatives of the state scalars that `residuals` read, by (use, tangent)."""
    seeds: dict[int, dict[tuple[int, int], int]] = {}
    live = set(graph.live(residuals))
    for key in list(graph.inputs):
        node = graph.input(key)
        if not isinstance(key, StateInput) or node not in live:
            continue
        use, offset = key
        state = uses.states[uses.uses[use].entity]
        tangents = state.tangents[offset]
        nodes = list(tangents.values())
        known = {
            state.graph.input(o): graph.input(StateInput(use, o))
            for o in see_inputs(state.graph, nodes)
        }
        copies = state.graph.copy(nodes, graph, known)
        seeds[node] = {(use, k): c for k, c in zip(tangents, copies, strict=True)}
    return seeds


def _assemble(
    site: ConstraintSite,
    states: Sequence[StateModel],
    graph: Graph,
    scalariser: Scalariser,
    uses: _Uses,
    residuals: list[int],
    jacobian: dict[tuple[int, int, int], int],
    still_guard: Typed | None,
    moving_guard: int | None,
    row_sums: RowSums | None = None,
) -> Kernel:
    outputs = [*residuals, *jacobian.values()]
    guards = [] if moving_guard is None else [moving_guard]
    look_ups = scalariser.look_ups
    assert isinstance(look_ups, LookUps)
    outputs += [*guards, *look_ups.arguments]
    live = graph.live(outputs)
    keys = [graph.key(n) for n in live if graph.ops[n] == "input"]
    state_keys = sorted(k for k in keys if isinstance(k, StateInput))
    raw_keys = sorted(k for k in keys if isinstance(k, RawInput))
    state_nodes = {graph.input(k) for k in state_keys}
    if guards:
        state_nodes.add(graph.input(LANE))
    records = look_ups.lanes
    state_nodes.update(records)

    lane_nodes, uniform_nodes = hoist(site, graph, outputs, live, state_nodes, raw_keys)
    on = [graph.const(1.0)] * len(guards)  # every instance is active until the guard is evaluated
    none = [graph.const(0.0)] * len(records)  # nothing is looked up before the first evaluation
    prepare = graph.tape([*lane_nodes, *none, *on, *uniform_nodes], inputs=raw_keys)
    first_record = len(lane_nodes)
    lane_nodes += records
    if guards:
        lane_nodes.append(graph.input(LANE))

    kernel = BoundedGraph(site.label, site.span)
    columns: dict[int, int] = {}
    input_keys: list[Hashable] = []
    for key in state_keys:
        columns[graph.input(key)] = kernel.input(key)
        input_keys.append(key)
    for kind, nodes in (("data", lane_nodes), ("uniform", uniform_nodes)):
        for number, node in enumerate(nodes):
            columns[node] = kernel.input((kind, number))
            input_keys.append((kind, number))
    moved = graph.copy(outputs, kernel, columns)
    r, end = moved[: len(residuals)], len(residuals) + len(jacobian)
    holds, arguments = moved[end : end + len(guards)], moved[end + len(guards) :]
    entries = dict(zip(jacobian, moved[len(residuals) : end], strict=True))
    # What cancelled to zero when hoisting re-simplified it is no entry any more.
    zero = kernel.const(0.0)
    entries = {k: n for k, n in entries.items() if n != zero}

    results = [*r, *entries.values()]
    gradient: dict[tuple[int, int], int] = {}
    products: dict[tuple[int, int, int, int], int] = {}
    large = many_products(entries, site) or len(kernel) > 4 * LARGEST_BODY
    if not large:
        gradient, products = products_of(kernel, r, entries)
    everything = [*results, *gradient.values(), *products.values()]
    tape = kernel.tape(results, inputs=input_keys)
    linearise = kernel.tape(everything, inputs=input_keys)
    parts = None
    if large or linearise.operations > LARGEST_BODY:
        linearise, gradient, products = tape, {}, {}
        parts = cut(tape, len(r), len(state_keys))

    assert isinstance(scalariser.totals, Totals)
    guard, guard_raw, guard_totals = _of_data(
        still_guard, site, states, scalariser.functions, "when"
    )
    sigma, sigma_raw, sigma_totals = _of_data(
        site.sigma, site, states, scalariser.functions, "sigma"
    )
    totals = (*scalariser.totals.found, *guard_totals, *sigma_totals)
    group = Group(
        label=site.label,
        struct=site.struct,
        constraint=site.name,
        where=str(site.span),
        table=site.table,
        prefix=site.prefix,
        residuals=len(r),
        slots=slots_of_rows(site),
        totals=totals,
        lengths=() if row_sums is None else _empty(row_sums),
        row_sums=row_sums,
        uses=tuple(uses.uses),
        raw=tuple(Raw(*key) for key in raw_keys),
        prepare=prepare,
        data_count=len(lane_nodes),
        uniform_count=len(uniform_nodes),
        states=tuple((use, offset) for use, offset in state_keys),
        tape=tape,
        jacobian=tuple(entries),
        lead=_lead(site, states, uses.uses),
        workspace=0 if parts is None else parts.width,
        places=tuple(scalariser.places),
        guard=guard,
        guard_raw=guard_raw,
        sigma=sigma,
        sigma_raw=sigma_raw,
        moving_guard=kernel.tape(holds, inputs=input_keys) if holds else None,
        look_ups=look_ups.placed(first_record),
        arguments=kernel.tape(arguments, inputs=input_keys) if arguments else None,
        guard_text="" if site.guard is None else " ".join(site.guard.span.text.split()),
        triplets=site.triplets,
        triplet_pairs=triplet_pairs(site, states, uses.uses),
        loss_text="" if site.loss is None else site.loss.text,
        index_column=site.index_column,
        require=site.require,
        require_text=site.require_text,
        units=site.units,
        operations_before=kernel.tree_operations(results if parts else everything),
        operations_after=linearise.operations,
        doc=site.doc,
    )
    return Kernel(
        group=group,
        cost=kernel.tape(r, inputs=input_keys),
        linearise=linearise,
        gradient=tuple(gradient),
        products=tuple(products),
        parts=parts,
        state_names=tuple(
            _state_name(site, uses.uses[use], states, offset) for use, offset in state_keys
        ),
        data_names=tuple(_node_name(site, graph, n) for n in lane_nodes),
        uniform_names=tuple(_node_name(site, graph, n) for n in uniform_nodes),
    )


def _of_data(
    value: Typed | None,
    site: ConstraintSite,
    states: Sequence[StateModel],
    functions: Calls,
    mark: str,
) -> tuple[Tape | None, tuple[Raw, ...], tuple[Total, ...]]:
    """A value over data alone, what it reads, and its sums over rows; `mark` names these.

    It is evaluated once per solve; None for no value.
    """
    if value is None:
        return None, (), ()
    graph = BoundedGraph(site.label, site.span)
    uses = _Uses(site, states)
    scalariser, totals = Scalariser(graph, uses, functions), Totals(graph, site, uses.uses, mark)
    scalariser.totals = totals
    scalariser.look_ups = look_ups = LookUps(graph, site)
    nodes = list(scalariser.nodes(value))
    look_ups.require_none(f"the {mark} of a constraint, which is evaluated before a solve")
    live = set(graph.live(nodes))
    keys = [k for k in graph.inputs if isinstance(k, RawInput) and graph.input(k) in live]
    return graph.tape(nodes, inputs=keys), tuple(Raw(*key) for key in keys), tuple(totals.found)


def _empty(row_sums: RowSums) -> tuple[Length, ...]:
    """Every list that is summed over term by term, without rows."""
    slots = row_sums.slots
    return tuple(Length(owner, slots[rows].table) for owner, rows in row_sums.lists)


def _lead(
    site: ConstraintSite, states: Sequence[StateModel], uses: Sequence[Use]
) -> tuple[int, ...]:
    entities = [state.entity for state in states]
    return leading(uses, site.slots, [e.table for e in entities], [e.tangent for e in entities])


def _slot_name(site: ConstraintSite, slot: int) -> str:
    steps = site.slots[slot].steps
    if not steps:
        return ""
    return ".".join(s.shown for s in steps) + "."


def _state_name(site: ConstraintSite, use: Use, states: Sequence[StateModel], offset: int) -> str:
    """Name of a scalar of a state as a reader of generated code would write it."""
    state = states[use.entity]
    return f"{_slot_name(site, use.slot)}{state.entity.prefix}{state.names[offset]}"


def _node_name(site: ConstraintSite, graph: Graph, node: int) -> str:
    if graph.ops[node] == "input":
        key = graph.key(node)
        if key == LANE:
            return "whether the guard holds"
        if isinstance(key, RecordInput):
            return _record_name(key)
        if isinstance(key, SumInput):
            return f"sum{key.sum + 1}[{key.component}]"
        if not isinstance(key, RawInput):
            return f"{key!r}"
        slot, column, component = key
        if "#" in column:
            of = f"{_slot_name(site, slot)}{column.partition('#')[0]}"
            return f"sum {component + 1} over {of}"
        return f"{_slot_name(site, slot)}{column}[{component}]"
    shown = [_operand(site, graph, a) for a in graph.args[node]]
    if all(shown):
        return f"{graph.ops[node]} of {' and '.join(shown)}"
    names = sorted(
        {_node_name(site, graph, n) for n in graph.live([node]) if graph.ops[n] == "input"}
    )
    shown = names[:3] + ["..."] * (len(names) > 3)
    return f"{graph.ops[node]} of {', '.join(shown)}"


def _record_name(key: RecordInput) -> str:
    what = "interval" if key.component < 0 else f"record[{key.component}]"
    return f"{what} of look-up {key.look_up + 1}"


def _operand(site: ConstraintSite, graph: Graph, node: int, depth: int = 2) -> str:
    """An input, a number, or an operation on such; "" for what is longer."""
    value = graph.value(node)
    if value is not None:
        return repr(value)
    if graph.ops[node] == "input":
        return _node_name(site, graph, node)
    args = [_operand(site, graph, a, depth - 1) for a in graph.args[node]] if depth else [""]
    return f"{graph.ops[node]}({', '.join(args)})" if all(args) else ""
