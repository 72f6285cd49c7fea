"""Constraints and parameter sets as programs over plain arrays.

A compiled kernel reads states (stored scalars and what is cached beside them) and prepared data.
Here these programs are joined: what `refresh` makes of the stored scalars at a step of zero, what
`prepare` makes of data, then residuals and derivatives. Operations and their order stay.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass

from arael.compiler.groups import Kernel
from arael.exporting.arrays import ParameterSet
from arael.manifolds.parameters import parameter_type
from arael.manifolds.parameters.kind import plain
from arael.runtime.layout import Entity, Group, Layout
from arael.runtime.machine.tape import NATIVE, Tape
from arael.symbolic.graph import Graph, Prescribed


@dataclass(frozen=True)
class ConstraintProgram:
    """One constraint over stored scalars and raw data.

    Inputs of `tape` are ("stored", use, k) and ("raw", number), in the order of `inputs`. Outputs
    are the guards (0 where inactive), the residuals, then the entries of the Jacobian.

    Attributes
    ----------
    group : of the layout
    guards : how many of the outputs are guards
    entries : (residual, use, tangent) of each entry
    """

    group: Group
    tape: Tape
    inputs: tuple[Hashable, ...]
    guards: int
    entries: tuple[tuple[int, int, int], ...]


def constraint_program(kernel: Kernel, layout: Layout) -> ConstraintProgram:
    """Join the programs of a constraint."""
    group = kernel.group
    graph = Graph()
    raw = [graph.input(("raw", k)) for k in range(len(group.raw))]
    states = [
        _state(graph, layout.entities[use.entity], number) for number, use in enumerate(group.uses)
    ]
    prepared = inline(graph, group.prepare, raw)
    inputs = [*(states[use][offset] for use, offset in group.states), *prepared]
    guards = []
    if group.guard is not None:
        columns = {(r.slot, r.column, r.component): k for k, r in enumerate(group.raw)}
        data = []
        for number, one in enumerate(group.guard_raw):
            known = columns.get((one.slot, one.column, one.component))
            data.append(graph.input(("guard", number)) if known is None else raw[known])
        guards += inline(graph, group.guard, data)
    if group.moving_guard is not None:
        guards += inline(graph, group.moving_guard, inputs)
    outputs = inline(graph, group.tape, inputs, places=True)
    keys = [key for key in graph.inputs if graph.input(key) in graph.live([*guards, *outputs])]
    tape = graph.tape([*guards, *outputs], inputs=keys)
    return ConstraintProgram(group, tape, tuple(keys), len(guards), group.jacobian)


def _state(graph: Graph, entity: Entity, use: int) -> list[int]:
    """The state of an entity at its stored scalars."""
    stored = [graph.input(("stored", use, k)) for k in range(entity.stored)]
    zero = [graph.const(0.0)] * entity.tangent
    return inline(graph, entity.refresh, [*stored, *zero])


def retraction(entity: Entity) -> Tape:
    """Stored scalars and a step -> stored scalars; the updates of components included."""
    graph = Graph()
    inputs = [graph.input(("stored", k)) for k in range(entity.stored)]
    inputs += [graph.input(("step", k)) for k in range(entity.tangent)]
    moved = inline(graph, entity.refresh, inputs)
    return graph.tape(moved[: entity.stored], inputs=list(graph.inputs))


def local_coordinates(parameters: ParameterSet) -> Tape:
    """Stored scalars of two rows -> the step that leads from the first to the second."""
    graph = Graph()
    entity = parameters.entity
    first = [graph.input(("first", k)) for k in range(entity.stored)]
    second = [graph.input(("second", k)) for k in range(entity.stored)]
    step: list[int] = []
    for use in entity.params:
        if use.tangent:
            kind = plain("", use.stored) if use.kind in ("real", "vec") else None
            kind = kind or parameter_type(use.kind)
            at = slice(use.stored_start, use.stored_start + use.stored)
            step += kind.local(graph, first[at], second[at])[: use.tangent]
    return graph.tape(step, inputs=list(graph.inputs))


def tangent_programs(entity: Entity) -> tuple[Tape, Tape]:
    """Derivatives of the stored scalars by a step at zero, and of a step by them, row by row.

    The columns of the first, P, are orthogonal for every type of parameter, so the second is
    ``diag(P'P)^-1 P'``, whose product with P is the unit matrix.
    """
    graph = Graph()
    stored = [graph.input(("stored", k)) for k in range(entity.stored)]
    zero = graph.const(0.0)
    plus = [[zero] * entity.tangent for _ in stored]
    for use in entity.params:
        if use.tangent:
            kind = plain("", use.stored) if use.kind in ("real", "vec") else None
            kind = kind or parameter_type(use.kind)
            own = stored[use.stored_start : use.stored_start + use.stored]
            rows = kind.tangent(graph, own, kind.caches(graph, own))
            for k, row in enumerate(rows):
                for tangent, node in row.items():
                    plus[use.stored_start + k][use.tangent_start + tangent] = node
    minus = []
    for k in range(entity.tangent):
        column = [row[k] for row in plus]
        norm = zero
        for node in column:
            norm = graph.op("add", norm, graph.op("mul", node, node))
        minus += [graph.op("div", node, norm) for node in column]
    keys = list(graph.inputs)
    return graph.tape([n for row in plus for n in row], keys), graph.tape(minus, keys)


def inline(graph: Graph, tape: Tape, inputs: Sequence[int], *, places: bool = False) -> list[int]:
    """Make the nodes of `tape` in `graph`, its inputs being `inputs`; return its outputs."""
    nodes: list[int] = []
    for number, (op, args) in enumerate(zip(tape.ops, tape.args, strict=True)):
        if places and tape.places:
            graph.place = tape.places[number] if tape.places[number] >= 0 else None
        if op == "input":
            nodes.append(inputs[args[0]])
        elif op == "const":
            nodes.append(graph.const(tape.constants[args[0]]))
        elif op.startswith(NATIVE):
            function = Prescribed(op.removeprefix(NATIVE), native=True)
            nodes.append(graph.call(function, [nodes[a] for a in args]))
        else:
            nodes.append(graph.op(op, *(nodes[a] for a in args)))
    graph.place = None
    return [nodes[k] for k in tape.outputs]
