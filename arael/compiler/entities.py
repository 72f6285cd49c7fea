"""The state of an entity: the values of a row that kernels read, its retraction and derivatives.

A state begins with the stored scalars of every parameter and the stored values of components. Then
come the caches of their types (sines, rotation matrices), values of formulas of components, and
those derivatives that are cheaper to read than to compute per observation.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import prod
from typing import cast

from arael.check.typed import Definition, EntitySite
from arael.compiler.bounded import BoundedGraph
from arael.compiler.component_state import (
    CARRIED,
    RowScalariser,
    computed,
    given,
    names_of,
    needs_native,
    set_by_updates,
    updated,
)
from arael.compiler.scalar_programs import Functions
from arael.diagnostics.records import AraelError, Diagnostic
from arael.manifolds.parameters import ParameterType, parameter_type
from arael.manifolds.parameters.kind import numbered, plain
from arael.runtime.layout import Entity, Param, ParamUse
from arael.symbolic.graph import Graph
from arael.symbolic.jacobian import jacobian

# A derivative of a cached value that takes more operations than this is cached as well: reading a
# scalar per lane costs about as much as two or three vector operations.
INLINE_OPERATIONS = 2

# Operations of one refresh program; those of a rotation take about a hundred.
MAX_REFRESH = 20_000


@dataclass
class StateModel:
    """How constraints see one entity.

    Attributes
    ----------
    entity : what the runtime needs
    caches : parameter column -> cache name -> offsets in the state
    graph : expressions over state scalars (inputs keyed by offset)
    tangents : per state scalar, {tangent index: node of `graph`}
    names : per state scalar, a readable name (``pos.x``, ``ea.R[0,2]``)
    """

    entity: Entity
    caches: dict[str, dict[str, tuple[int, ...]]]
    graph: Graph
    tangents: list[dict[int, int]]
    names: list[str]
    stored_at: dict[str, ParamUse] = field(default_factory=dict)


def model_state(site: EntitySite, functions: Functions | None = None) -> StateModel:
    """Lay out the state of the entity at `site` and derive its refresh program and tangents.

    Raises
    ------
    AraelError
        E0620: the formulas of its components take too many operations.
    """
    state = _Laying(site, functions or Functions())
    state.move_parameters()
    state.keep_caches()
    state.keep_formulas()
    return state.model()


class _Laying:
    """A state in the making: scalars are appended with their names and tangents."""

    def __init__(self, site: EntitySite, calls: Functions) -> None:
        self.site, self.calls = site, calls
        self.uses = _uses(site)
        self.stored_at = {use.column: use for use in self.uses}
        self.move = _graph(site)  # stored scalars and a step -> new state
        self.see = _graph(site)  # state scalars -> derivatives
        self.outputs: list[int] = []
        self.names: list[str] = []
        self.tangents: list[dict[int, int]] = []
        self.caches: dict[str, dict[str, tuple[int, ...]]] = {}
        self.extra: dict[int, int] = {}  # derivative node of `see` -> offset where it is kept
        self.tangent_names = [
            use.column.removeprefix(site.prefix) + suffix
            for use in self.uses
            for suffix in _type_of(use).tangent_names[: use.tangent]
        ]
        self.stored = sum(use.stored for use in self.uses)

    def move_parameters(self) -> None:
        """Lay out the stored scalars: parameters retracted, then updated."""
        stored_in = [self.move.input(("stored", i)) for i in range(self.stored)]
        step_in = [self.move.input(("step", i)) for i in range(len(self.tangent_names))]
        row: dict[str, list[int]] = {}
        steps: dict[str, list[int]] = {}
        for use in self.uses:
            stored = stored_in[use.stored_start : use.stored_start + use.stored]
            step = step_in[use.tangent_start : use.tangent_start + use.tangent]
            kind = _type_of(use)
            row[use.column] = kind.retract(self.move, stored, step) if use.tangent else stored
            steps[use.column] = step
        params = {c.path: c.param for c in self.site.columns if c.param is not None}
        row = updated(self.move, row, steps, params, self.site.components, self.calls)
        for use in self.uses:
            short = use.column.removeprefix(self.site.prefix)
            names = [short + suffix for suffix in _type_of(use).stored_names]
            self._append(row[use.column], names)

    def keep_caches(self) -> None:
        """Lay out what each kind of parameter keeps beside its stored scalars."""
        pending: list[tuple[ParamUse, dict[str, list[int]], list[int]]] = []
        for use in self.uses:
            kind = _type_of(use)
            at = range(use.stored_start, use.stored_start + use.stored)
            seen: dict[str, list[int]] = {}
            self.caches[use.column] = {}
            short = use.column.removeprefix(self.site.prefix)
            for name, nodes in kind.caches(self.move, [self.outputs[o] for o in at]).items():
                offsets = self._append(nodes, _cache_names(short, name, len(nodes)))
                self.caches[use.column][name] = offsets
                seen[name] = [self.see.input(o) for o in offsets]
            stored = [self.see.input(o) for o in at]
            rows = kind.tangent(self.see, stored, seen) if use.tangent else [{} for _ in at]
            for offset, row in zip(at, rows, strict=True):
                self.tangents[offset] = {use.tangent_start + k: n for k, n in row.items()}
            pending.append((use, seen, stored))
        for use, seen, stored in pending:
            for name, rows in _type_of(use).cache_tangents(self.see, stored, seen).items():
                for offset, row in zip(self.caches[use.column][name], rows, strict=True):
                    self._keep_tangents(
                        offset, {use.tangent_start + k: node for k, node in row.items()}
                    )

    def keep_formulas(self) -> None:
        """Lay out the values of formulas of components, with their derivatives."""
        row = {
            u.column: self.outputs[u.stored_start : u.stored_start + u.stored] for u in self.uses
        }
        values = computed(
            self.move,
            row,
            lambda read, cache: [self.outputs[o] for o in self.caches[read.column][cache]],
            self.site.components,
            self.calls,
        )
        for component in self.site.components:
            for definition in component.computed:
                self._append_formula(definition, values[definition.column])
        for component in self.site.components:
            for definition in component.symbolic:
                self._keep_symbolic(definition)

    def _keep_symbolic(self, definition: Definition) -> None:
        """Keep the value of a ``symbolic`` field, unless it is as cheap to compute as to read."""
        see = self.see
        row = {
            u.column: [see.input(u.stored_start + k) for k in range(u.stored)]
            for u in self.stored_at.values()
        }
        nodes = RowScalariser(
            see,
            row,
            self.calls,
            cache=lambda read, cache: [see.input(o) for o in self.caches[read.column][cache]],
        ).nodes(definition.value)
        if all(see.tree_operations([n]) <= INLINE_OPERATIONS for n in nodes):
            return
        seeds = {see.input(o): self.tangents[o] for o in see_inputs(see, nodes)}
        rows = jacobian(see, nodes, {node: row for node, row in seeds.items() if row})
        if needs_native(see, [*nodes, *(n for row in rows for n in row.values())]):
            return
        offsets = self._append_formula(definition, self._moved(nodes))
        for offset, tangents in zip(offsets, rows, strict=True):
            self._keep_tangents(offset, {k: n for k, n in tangents.items() if see.value(n) != 0})

    def _append(self, nodes: Sequence[int], names: Sequence[str]) -> tuple[int, ...]:
        """Append scalars that no step changes, and return their offsets."""
        first = len(self.outputs)
        self.outputs += nodes
        self.names += names
        self.tangents += [{} for _ in nodes]
        return tuple(range(first, len(self.outputs)))

    def _append_formula(self, definition: Definition, nodes: Sequence[int]) -> tuple[int, ...]:
        offsets = self._append(nodes, names_of(definition, self.site.prefix))
        self.stored_at[definition.column] = ParamUse(
            definition.column, "", offsets[0], len(nodes), 0, 0
        )
        return offsets

    def _moved(self, nodes: Sequence[int]) -> list[int]:
        """Nodes of `see` as nodes of `move`."""
        inputs = {self.see.input(o): self.outputs[o] for o in see_inputs(self.see, list(nodes))}
        return self.see.copy(list(nodes), self.move, inputs)

    def _keep_tangents(self, offset: int, tangents: Mapping[int, int]) -> None:
        """Note the derivatives of a scalar; those that are costly are kept in the state too."""
        for k, node in tangents.items():
            if self.see.tree_operations([node]) > INLINE_OPERATIONS:
                if node not in self.extra:
                    name = f"d({self.names[offset]})/d({self.tangent_names[k]})"
                    (self.extra[node],) = self._append(self._moved([node]), [name])
                node = self.see.input(self.extra[node])
            self.tangents[offset][k] = node

    def model(self) -> StateModel:
        """Return the whole."""
        site = self.site
        steps = len(self.tangent_names)
        refresh = self.move.tape(
            self.outputs,
            inputs=[
                *(("stored", i) for i in range(self.stored)),
                *(("step", i) for i in range(steps)),
            ],
        )
        if site.components and refresh.operations > MAX_REFRESH:
            raise AraelError(
                Diagnostic(
                    "E0620",
                    f"the components of {site.struct} take {refresh.operations} operations a step, "
                    f"more than {MAX_REFRESH}",
                    site.components[-1].span,
                    help=("split the formulas, or move what depends on data alone into the data",),
                )
            )
        formulas, values = given(self.uses, site.components, self.calls)
        entity = Entity(
            struct=site.struct,
            table=site.table,
            prefix=site.prefix,
            params=tuple(self.uses),
            stored=self.stored,
            tangent=steps,
            state=len(self.outputs),
            refresh=refresh,
            tangent_names=tuple(self.tangent_names),
            updated=tuple(
                u.column for u in self.uses if u.column in set_by_updates(site.components)
            ),
            formulas=formulas,
            values=values,
        )
        return StateModel(entity, self.caches, self.see, self.tangents, self.names, self.stored_at)


def _uses(site: EntitySite) -> list[ParamUse]:
    """Places of the columns in the state; what is carried along is moved by no step."""
    uses: list[ParamUse] = []
    stored = tangent = 0
    for column in site.columns:
        param = column.param or Param(CARRIED, prod(column.shape), 0)
        uses.append(ParamUse(column.path, param.kind, stored, param.stored, tangent, param.tangent))
        stored += param.stored
        tangent += param.tangent
    return uses


def _graph(site: EntitySite) -> Graph:
    if not site.components:
        return Graph()
    last = site.components[-1]
    return BoundedGraph(last.struct, last.span)


def _type_of(use: ParamUse) -> ParameterType:
    if use.kind in ("vec", CARRIED):
        return plain(f"vec{use.stored}", use.stored)
    return parameter_type(use.kind)


def see_inputs(see: Graph, nodes: list[int]) -> list[int]:
    """State offsets that expressions over the state read."""
    return [cast(int, see.key(n)) for n in see.live(nodes) if see.ops[n] == "input"]


def _cache_names(param: str, cache: str, count: int) -> list[str]:
    if cache.isupper():
        n = 3 if count == 9 else 2
        return [f"{param}.{cache}[{i // n},{i % n}]" for i in range(count)]
    return [f"{cache}({param}{s})" for s in numbered(count)]
