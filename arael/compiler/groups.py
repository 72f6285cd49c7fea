"""From a typed constraint to what is evaluated: residuals, derivatives, and what can be done once.

The steps, each a function: scalarise the residual; put its loss into it; differentiate the
straight-line program; hoist what depends on data alone into a program that runs once per solve;
form the products J'J and J'r.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from arael.check.typed import ConstraintSite, Typed
from arael.compiler.bounded import BoundedGraph
from arael.compiler.entities import StateModel, see_inputs
from arael.compiler.lead import leading
from arael.compiler.losses import robustify
from arael.compiler.moving_guards import LANE, split, switched
from arael.compiler.parts import Parts, cut
from arael.compiler.scalar_programs import Functions
from arael.compiler.scalarise import Calls, RawInput, Scalariser, StateInput
from arael.diagnostics.records import AraelError, Diagnostic
from arael.runtime.layout import Group, Raw, Use
from arael.runtime.machine.library import FUNCTIONS
from arael.runtime.machine.tape import Tape
from arael.symbolic.graph import Graph
from arael.symbolic.jacobian import derive
from arael.symbolic.jacobian import jacobian as differentiate

if TYPE_CHECKING:
    from arael.symbolic.sharing import Shared

# A constraint that exceeds one of these is large: its arithmetic is compiled in parts, and its
# products J'r and J'J are formed by loops over the Jacobian, because the C compiler's time grows
# faster than what a single function gains.
UNROLLED_PRODUCTS = 1500  # multiplications in J'J
UNROLLED_TARGETS = 150  # entries of J'J
LARGEST_BODY = 1500  # operations of residuals, derivatives and products

# Multiplications in J'J of one instance beyond which a constraint is refused: one residual of some
# 3000 parameters, whose block of the Hessian takes 40 MB.
MAX_PRODUCTS = 5_000_000

# Hoisting may need more lane inputs than the data has scalars; beyond this many more it is not
# worth the memory traffic and only costly operations are hoisted.
EXTRA_LANES = 6
COSTLY = frozenset(("div", *(f.name for f in FUNCTIONS)))


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
    """Derivatives of a constraint before they are written as a program.

    Attributes
    ----------
    residuals : nodes
    shared : their derivatives by (use, tangent), over the graph of the residuals
    names : of the inputs of that graph, by node
    tangents : names of what is differentiated by
    """

    residuals: list[int]
    shared: Shared[tuple[int, int]]
    names: dict[int, str]
    tangents: dict[tuple[int, int], str]


class _Uses:
    """Numbers the entities that a constraint reads, in order of appearance."""

    def __init__(self, site: ConstraintSite, states: Sequence[StateModel]) -> None:
        self.site = site
        self.states = states
        self.uses: list[Use] = []

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
    jacobian = _differentiate(graph, residuals, uses)
    kernel = _assemble(site, states, graph, scalariser, uses, residuals, jacobian, guard, holds)
    return kernel, scalariser.chains


def derivatives(
    site: ConstraintSite,
    states: Sequence[StateModel],
    single: bool = False,
    functions: Functions | None = None,
) -> Derivatives | None:
    """Derivatives of one constraint as SymPy has them; None if nothing varies."""
    scalariser, uses, residuals, _, _ = _scalarise(
        site, states, single, functions or Functions(), factored=True
    )
    graph = scalariser.graph
    seeds = _seeds(graph, residuals, uses)
    if not any(seeds.values()):
        return None
    names: dict[int, str] = {}
    for key in list(graph.inputs):
        node = graph.input(key)
        if isinstance(key, StateInput):
            names[node] = _state_name(site, uses.uses[key.use], states, key.offset)
        else:
            names[node] = _node_name(site, graph, node)
    tangents = {
        (use, k): f"{_slot_name(site, u.slot)}{states[u.entity].entity.prefix}{name}"
        for use, u in enumerate(uses.uses)
        for k, name in enumerate(states[u.entity].entity.tangent_names)
    }
    return Derivatives(residuals, derive(graph, residuals, seeds), names, tangents)


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
) -> Kernel:
    outputs = [*residuals, *jacobian.values()]
    guards = [] if moving_guard is None else [moving_guard]
    outputs += guards
    live = graph.live(outputs)
    keys = [graph.key(n) for n in live if graph.ops[n] == "input"]
    state_keys = sorted(k for k in keys if isinstance(k, StateInput))
    raw_keys = sorted(k for k in keys if isinstance(k, RawInput))
    state_nodes = {graph.input(k) for k in state_keys}
    if guards:
        state_nodes.add(graph.input(LANE))

    lane_nodes, uniform_nodes = _hoist(site, graph, outputs, live, state_nodes, raw_keys)
    on = [graph.const(1.0)] * len(guards)  # every instance is active until the guard is evaluated
    prepare = graph.tape([*lane_nodes, *on, *uniform_nodes], inputs=raw_keys)
    if guards:
        lane_nodes.append(graph.input(LANE))

    kernel = BoundedGraph(site.label, site.span)
    known: dict[int, int] = {}
    input_keys: list[Hashable] = []
    for key in state_keys:
        known[graph.input(key)] = kernel.input(key)
        input_keys.append(key)
    for kind, nodes in (("data", lane_nodes), ("uniform", uniform_nodes)):
        for number, node in enumerate(nodes):
            known[node] = kernel.input((kind, number))
            input_keys.append((kind, number))
    moved = graph.copy(outputs, kernel, known)
    r, holds = moved[: len(residuals)], moved[len(residuals) + len(jacobian) :]
    entries = dict(zip(jacobian, moved[len(residuals) : len(moved) - len(holds)], strict=True))
    # What cancelled to zero when hoisting re-simplified it is no entry any more.
    zero = kernel.const(0.0)
    entries = {k: n for k, n in entries.items() if n != zero}

    results = [*r, *entries.values()]
    gradient: dict[tuple[int, int], int] = {}
    products: dict[tuple[int, int, int, int], int] = {}
    large = _many_products(entries, site) or len(kernel) > 4 * LARGEST_BODY
    if not large:
        gradient, products = _products(kernel, r, entries)
    everything = [*results, *gradient.values(), *products.values()]
    tape = kernel.tape(results, inputs=input_keys)
    linearise = kernel.tape(everything, inputs=input_keys)
    parts = None
    if large or linearise.operations > LARGEST_BODY:
        linearise, gradient, products = tape, {}, {}
        parts = cut(tape, len(r), len(state_keys))

    guard, guard_raw = _guard(still_guard, site, states, scalariser.functions)
    group = Group(
        label=site.label,
        struct=site.struct,
        constraint=site.name,
        where=str(site.span),
        table=site.table,
        prefix=site.prefix,
        residuals=len(r),
        slots=site.slots,
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
        moving_guard=kernel.tape(holds, inputs=input_keys) if holds else None,
        guard_text="" if site.guard is None else " ".join(site.guard.span.text.split()),
        triplets=site.triplets,
        triplet_pairs=_triplet_pairs(site, states, uses.uses),
        loss_text="" if site.loss is None else site.loss.text,
        index_column=site.index_column,
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


def _hoist(
    site: ConstraintSite,
    graph: Graph,
    outputs: list[int],
    live: list[int],
    states: set[int],
    raw_keys: list[RawInput],
) -> tuple[list[int], list[int]]:
    """Nodes that depend on data alone and feed what depends on parameters.

    Returns lane inputs (one value per instance) and uniforms (functions of the root's data only).
    """
    moving = graph.depends(states)
    frontier = _frontier(graph, outputs, live, moving, lambda _: True)
    if len(frontier) > len(raw_keys) + EXTRA_LANES:
        costly = {n for n in live if graph.ops[n] in COSTLY or graph.ops[n] in graph.functions}
        below = graph.depends(costly)
        frontier = _frontier(graph, outputs, live, moving, lambda n: n in below)
    varying = graph.depends(
        {graph.input(k) for k in raw_keys if not _is_root(site, k.slot)},
    )
    frontier = _lean(graph, frontier, varying)
    lanes = [n for n in frontier if n in varying]
    uniforms = [n for n in frontier if n not in varying]
    return lanes, uniforms


def _lean(graph: Graph, frontier: list[int], varying: set[int]) -> list[int]:
    """Leave out products of other lanes: to multiply costs less than to read.

    Lanes are made in f64 and rounded to the precision of the kernel. Of rounded lanes a product is
    as good as a rounded one; a difference, such as 1 - cos t, may have nothing left.
    """
    kept = set(frontier)
    for node in reversed(frontier):
        if node not in varying or graph.ops[node] not in ("mul", "neg"):
            continue
        operands = graph.operands(node)
        own = [n for n in operands if n in varying]
        if own and all(n in kept for n in own):
            kept.remove(node)
            kept.update(n for n in operands if n not in varying and graph.ops[n] != "const")
    return sorted(kept)


def _frontier(
    graph: Graph,
    outputs: list[int],
    live: list[int],
    moving: set[int],
    wanted: Callable[[int], bool],
) -> list[int]:
    """Find fixed nodes read by moving ones, or results, descending where not `wanted`."""
    found: set[int] = set()
    seen: set[int] = set()
    waiting = list(outputs)
    for node in live:
        if node in moving and graph.ops[node] != "input":
            waiting += graph.operands(node)
    while waiting:
        node = waiting.pop()
        op = graph.ops[node]
        if op == "const" or node in moving or node in seen:
            continue
        seen.add(node)
        if op == "input" or (op != "neg" and wanted(node)):
            found.add(node)
        else:
            waiting += graph.operands(node)
    return sorted(found)


def _is_root(site: ConstraintSite, slot: int) -> bool:
    return site.slots[slot].table == ""


def _products(
    g: Graph, residuals: list[int], entries: dict[tuple[int, int, int], int]
) -> tuple[dict[tuple[int, int], int], dict[tuple[int, int, int, int], int]]:
    """J'r by (use, tangent) and the lower half of J'J by (use a, use b, row, column)."""
    columns: dict[tuple[int, int], dict[int, int]] = {}
    for (k, use, tangent), node in sorted(entries.items()):
        columns.setdefault((use, tangent), {})[k] = node
    keys = sorted(columns)
    gradient = {c: _sum(g, [(n, residuals[k]) for k, n in columns[c].items()]) for c in keys}
    products = {}
    for p, (a, i) in enumerate(keys):
        for b, j in keys[: p + 1]:
            left, right = columns[a, i], columns[b, j]
            common = [(left[k], right[k]) for k in left if k in right]
            if common:
                products[a, b, i, j] = _sum(g, common)
    return gradient, products


def _many_products(entries: Iterable[tuple[int, int, int]], site: ConstraintSite) -> bool:
    """Whether J'J takes more than is spelled out, by the places of the Jacobian's entries.

    Raises
    ------
    AraelError
        E0620: it takes more than `MAX_PRODUCTS`.
    """
    rows: dict[int, list[tuple[int, int]]] = {}
    for residual, use, tangent in entries:
        rows.setdefault(residual, []).append((use, tangent))
    multiplications = sum(len(row) * (len(row) + 1) // 2 for row in rows.values())
    if multiplications > MAX_PRODUCTS:
        raise AraelError(
            Diagnostic(
                "E0620",
                f"J'J of `{site.label}` takes {multiplications} multiplications for each instance, "
                f"more than {MAX_PRODUCTS}",
                site.span,
                help=("split the residual into constraints of fewer parameters each",),
            )
        )
    if multiplications > UNROLLED_PRODUCTS:
        return True
    targets = {(a, b) for row in rows.values() for i, a in enumerate(row) for b in row[: i + 1]}
    return len(targets) > UNROLLED_TARGETS


def _sum(g: Graph, pairs: list[tuple[int, int]]) -> int:
    total = g.op("mul", *pairs[0])
    for left, right in pairs[1:]:
        total = g.op("add", total, g.op("mul", left, right))
    return total


def _guard(
    guard: Typed | None, site: ConstraintSite, states: Sequence[StateModel], functions: Calls
) -> tuple[Tape | None, tuple[Raw, ...]]:
    if guard is None:
        return None, ()
    graph = BoundedGraph(site.label, site.span)
    (node,) = Scalariser(graph, _Uses(site, states), functions).nodes(guard)
    keys = [key for key in graph.inputs if isinstance(key, RawInput)]
    return graph.tape([node], inputs=keys), tuple(Raw(*key) for key in keys)


def _lead(
    site: ConstraintSite, states: Sequence[StateModel], uses: Sequence[Use]
) -> tuple[int, ...]:
    entities = [state.entity for state in states]
    return leading(uses, site.slots, [e.table for e in entities], [e.tangent for e in entities])


def _triplet_pairs(
    site: ConstraintSite, states: Sequence[StateModel], uses: Sequence[Use]
) -> tuple[tuple[int, int], ...]:
    """Pairs of uses that go into `triplets`: those without a separate block."""
    if not site.triplets:
        return ()
    keys = [(site.slots[u.slot].steps, states[u.entity].entity.prefix) for u in uses]
    return tuple(
        (a, b)
        for b in range(len(uses))
        for a in range(b)
        if frozenset((keys[a], keys[b])) not in site.crossed
    )


def _slot_name(site: ConstraintSite, slot: int) -> str:
    steps = site.slots[slot].steps
    if not steps:
        return ""
    return ".".join(s.ref if s.kind == "ref" else s.kind for s in steps) + "."


def _state_name(site: ConstraintSite, use: Use, states: Sequence[StateModel], offset: int) -> str:
    """Name of a scalar of a state as a reader of generated code would write it."""
    state = states[use.entity]
    return f"{_slot_name(site, use.slot)}{state.entity.prefix}{state.names[offset]}"


def _node_name(site: ConstraintSite, graph: Graph, node: int) -> str:
    if graph.ops[node] == "input":
        key = graph.key(node)
        if key == LANE:
            return "whether the guard holds"
        assert isinstance(key, RawInput)
        slot, column, component = key
        return f"{_slot_name(site, slot)}{column}[{component}]"
    names = sorted(
        {_node_name(site, graph, n) for n in graph.live([node]) if graph.ops[n] == "input"}
    )
    shown = ", ".join(names[:3]) + (", ..." if len(names) > 3 else "")
    return f"{graph.ops[node]} of {shown}"
