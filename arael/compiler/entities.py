"""The state of an entity: what kernels read of a row, how it moves, how it changes with a step.

A state begins with the stored scalars of every parameter, goes on with the caches of their kinds
(sines, rotation matrices) and ends with derivatives of caches that would cost more to recompute per
observation than to read.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import prod
from typing import cast

from arael.check.typed import EntitySite
from arael.compiler.components import CARRIED, computed, updated
from arael.compiler.functions import Functions
from arael.runtime.layout import Entity, Param, ParamUse
from arael.symbolic.graph import Graph
from arael.symbolic.parameters import ParameterType, parameter_type
from arael.symbolic.parameters.kind import numbered
from arael.symbolic.parameters.plain import plain

# A derivative of a cached value that takes more operations than this is cached as well: reading a
# scalar per lane costs about as much as two or three vector operations.
INLINE_OPERATIONS = 2


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
    """Lay out the state of the entity at `site` and derive its refresh program and tangents."""
    uses: list[ParamUse] = []
    stored_total = tangent_total = 0
    for column in site.columns:
        # What a component carries is stored like a parameter that no step moves.
        param = column.param or Param(CARRIED, prod(column.shape), 0)
        uses.append(
            ParamUse(
                column.path, param.kind, stored_total, param.stored, tangent_total, param.tangent
            )
        )
        stored_total += param.stored
        tangent_total += param.tangent

    move = Graph()  # stored scalars and a step -> new state
    see = Graph()  # state scalars -> derivatives
    stored_in = [move.input(("stored", i)) for i in range(stored_total)]
    step_in = [move.input(("step", i)) for i in range(tangent_total)]

    outputs: list[int] = []
    names: list[str] = []
    tangent_names: list[str] = []
    for use in uses:
        kind = _type_of(use)
        stored = stored_in[use.stored_start : use.stored_start + use.stored]
        step = step_in[use.tangent_start : use.tangent_start + use.tangent]
        outputs += kind.retract(move, stored, step) if use.tangent else stored
        short = use.column.removeprefix(site.prefix)
        names += [short + suffix for suffix in kind.stored_names]
        tangent_names += [short + suffix for suffix in kind.tangent_names[: use.tangent]]

    calls = functions or Functions()
    outputs = updated(move, uses, outputs, step_in, site.components, calls)

    tangents: list[dict[int, int]] = [{} for _ in range(stored_total)]
    caches: dict[str, dict[str, tuple[int, ...]]] = {}
    pending: list[tuple[ParamUse, dict[str, list[int]], list[int]]] = []
    for use in uses:
        kind = _type_of(use)
        offsets = range(use.stored_start, use.stored_start + use.stored)
        seen: dict[str, list[int]] = {}
        caches[use.column] = {}
        short = use.column.removeprefix(site.prefix)
        for name, nodes in kind.caches(move, [outputs[o] for o in offsets]).items():
            start = len(outputs)
            outputs += nodes
            caches[use.column][name] = tuple(range(start, start + len(nodes)))
            seen[name] = [see.input(o) for o in caches[use.column][name]]
            names += _cache_names(short, name, len(nodes))
            tangents += [{} for _ in nodes]
        stored = [see.input(o) for o in offsets]
        rows = kind.tangent(see, stored, seen) if use.tangent else [{} for _ in stored]
        for offset, row in zip(offsets, rows, strict=True):
            tangents[offset] = {use.tangent_start + k: node for k, node in row.items()}
        pending.append((use, seen, stored))

    extra: dict[int, int] = {}  # derivative node of `see` -> offset of its cache
    for use, seen, stored in pending:
        kind = _type_of(use)
        short = use.column.removeprefix(site.prefix)
        for name, rows in kind.cache_tangents(see, stored, seen).items():
            for offset, row in zip(caches[use.column][name], rows, strict=True):
                for k, node in row.items():
                    if see.tree_operations([node]) > INLINE_OPERATIONS:
                        if node not in extra:
                            extra[node] = len(outputs)
                            known = {see.input(o): outputs[o] for o in see_inputs(see, [node])}
                            outputs.append(see.copy([node], move, known)[0])
                            names.append(
                                f"d({names[offset]})/d({tangent_names[use.tangent_start + k]})"
                            )
                        node = see.input(extra[node])
                    tangents[offset][use.tangent_start + k] = node
    stored_at = {u.column: u for u in uses}
    kept = computed(move, uses, outputs[:stored_total], site.components, calls)
    for column, values in kept.items():
        stored_at[column] = ParamUse(column, "computed", len(outputs), len(values), 0, 0)
        outputs += values
        short = column.removeprefix(site.prefix)
        names += [f"{short}{suffix}" for suffix in numbered(len(values))]
    tangents += [{} for _ in range(len(outputs) - len(tangents))]

    entity = Entity(
        struct=site.struct,
        table=site.table,
        prefix=site.prefix,
        params=tuple(uses),
        stored=stored_total,
        tangent=tangent_total,
        state=len(outputs),
        refresh=move.tape(
            outputs,
            inputs=[
                *(("stored", i) for i in range(stored_total)),
                *(("step", i) for i in range(tangent_total)),
            ],
        ),
        tangent_names=tuple(tangent_names),
        updated=any(component.updates for component in site.components),
    )
    return StateModel(entity, caches, see, tangents, names, stored_at)


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
