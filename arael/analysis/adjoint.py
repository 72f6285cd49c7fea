"""Derivatives of the half gradient by all that a problem reads, one direction at a time.

The solution is where the half gradient ``g(x, d) = J'r`` vanishes, x the parameters and d the data.
For a vector v over the parameters, ``phi_v = v'g = sum_i r_i (J_i v)`` is a sum over instances, and
its derivatives by data and by the parameters are rows of all that implicit differentiation needs:

    d(phi_v)/dd = v' (dg/dd),    d(phi_v)/dx = H v,    H = J'J + sum_i r_i (d2 r_i)

Both come from one program for each constraint: its residuals and Jacobian as the compiler wrote
them, then reverse mode (`arael.symbolic.reverse`). It is run by the expression machine on whole
columns. At a minimum, derivatives of g by the tangent are those of a symmetric matrix.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from math import prod
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from arael.runtime.layout import CONSTANT, Entity, Function, Group, Layout, Raw, columns_of
from arael.runtime.machine.programs import columns_of as columns_of_tape
from arael.runtime.machine.tape import Tape
from arael.runtime.problem import Problem
from arael.runtime.store.access import StoreLike, Walker, gather_all
from arael.symbolic.graph import Graph, Prescribed
from arael.symbolic.reverse import gradient, read_tape

Floats = NDArray[np.float64]
Place = tuple[str, str]
"""Table and column."""

_CONSTANT_PLACE: Place = ("", CONSTANT)
_AT_ONCE = 8192
"""Instances evaluated at once: their columns stay in the second-level cache."""


@dataclass
class Derivatives:
    """Derivatives of one scalar by all that was read.

    Attributes
    ----------
    data : (rows, scalars) by table and column
    states : per entity, (rows, state) by the state that kernels read
    """

    data: dict[Place, Floats] = field(default_factory=dict)
    states: list[Floats] = field(default_factory=list)


@dataclass(frozen=True)
class _Program:
    """Derivatives of a scalar of one group of constraints.

    Inputs are the states, the raw data, the weights, the records of look-ups, then the flag of a
    moving guard.

    Attributes
    ----------
    weights : what is given of v, or of weights of residuals: (use, tangent), or (residual, -1)
    raws, states : numbers of the inputs that the outputs are derivatives by: first by the raws
    """

    tape: Tape
    weights: tuple[tuple[int, int], ...]
    raws: tuple[int, ...]
    states: tuple[int, ...]


def gradient_products(
    problem: Problem,
    v: Floats,
    columns: Iterable[Place] | None = None,
    states: bool = True,
    touching: Sequence[NDArray[np.bool_]] | None = None,
) -> Derivatives:
    """Derivatives of ``v'g`` by data and by states.

    Residuals by own code read no data of the model; of their second derivatives there is nothing,
    and their part of ``H v`` is that of Gauss-Newton, which `hessian_product` adds.

    Parameters
    ----------
    v : (size,) over the scalars of the system
    columns : tables and columns of data to differentiate by; None: all
    states : whether to differentiate by states too
    touching : per entity, (rows,): instances that use none of these rows are left out; None: none
    """
    found = _nothing(problem)
    wide = np.concatenate([v, np.zeros(problem.structure.plan.trash)])
    for number, group in enumerate(problem.layout.groups):
        if problem.hooks is not None and number in problem.hooks.items:
            continue
        program = _program(problem.layout, group, "gradient", columns, states)
        if not (program.raws or program.states) or not len(problem.structure.active[number]):
            continue
        at = problem.structure.placements[number].gradient_at
        chosen = None
        if touching is not None:
            rows = problem.structure.placements[number].rows
            used = [touching[use.entity][rows[:, k]] for k, use in enumerate(group.uses)]
            chosen = np.flatnonzero(np.logical_or.reduce(used))
        weights = [wide[at[:, use] + tangent] for use, tangent in program.weights]
        _run(problem, number, program, weights, found, chosen=chosen)
    _spread_totals(problem, found.data)
    return found


def value_products(problem: Problem, number: int, weights: Floats) -> Derivatives:
    """Derivatives of a weighted sum of the residuals of one group by data and by states.

    Parameters
    ----------
    number : of the group
    weights : (residuals,)
    """
    found = _nothing(problem)
    program = _program(problem.layout, problem.layout.groups[number], "value", None, True)
    count = len(problem.structure.active[number])
    _run(problem, number, program, [np.full(count, weights[k]) for k, _ in program.weights], found)
    _spread_totals(problem, found.data)
    return found


class Varied(Protocol):
    """The groups that read a named constant, derived with it as raw inputs `CONSTANT`."""

    @property
    def groups(self) -> Mapping[int, Group]:
        """By their numbers."""

    @property
    def values(self) -> Floats:
        """(scalars,) of the constant."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Of the constant."""


def constant_products(
    problem: Problem, varied: Varied, v: Floats, of_values: Mapping[int, Floats] | None = None
) -> Floats:
    """(scalars,) derivatives by a constant, of ``v'g`` or of weighted sums of residuals.

    Parameters
    ----------
    v : (size,) over the scalars of the system
    of_values : weights (residuals,) of the residuals of groups; then of these, and `v` is not used
    """
    found = Derivatives({_CONSTANT_PLACE: np.zeros((1, len(varied.values)))}, [])
    wide = np.concatenate([v, np.zeros(problem.structure.plan.trash)])
    for number, group in varied.groups.items():
        if not len(problem.structure.active[number]):
            continue
        kind = "gradient" if of_values is None else "value"
        program = _program(problem.layout, group, kind, (_CONSTANT_PLACE,), False)
        if of_values is None:
            at = problem.structure.placements[number].gradient_at
            weights = [wide[at[:, use] + tangent] for use, tangent in program.weights]
        elif number in of_values:
            count = len(problem.structure.active[number])
            weights = [np.full(count, of_values[number][k]) for k, _ in program.weights]
        else:
            continue
        _run(problem, number, program, weights, found, (group, varied.values))
    (row,) = found.data[_CONSTANT_PLACE]
    return np.asarray(row)


def by_tangent(problem: Problem, states: Sequence[Floats]) -> list[Floats]:
    """Derivatives by steps of all rows, (rows, tangent) per entity, from those by states."""
    found = []
    for entity, current, by_state in zip(
        problem.layout.entities, problem.states, states, strict=True
    ):
        step = np.zeros((len(by_state), entity.tangent))
        moved = np.flatnonzero(by_state.any(axis=1))
        if len(moved) and entity.tangent:
            tape, wanted = _retraction(entity)
            stored = np.asarray(current, dtype=np.float64)[moved, : entity.stored]
            columns = [*stored.T, *by_state[moved][:, list(wanted)].T]
            step[moved] = _outputs(tape, columns, len(moved)).T
        found.append(step)
    return found


def in_system(problem: Problem, steps: Sequence[Floats]) -> Floats:
    """(size,) derivatives by the scalars of the system, from those by steps of all rows."""
    found = np.zeros(problem.size)
    for entity, blocks, one in zip(
        problem.layout.entities, problem.structure.system.blocks, steps, strict=True
    ):
        rows = np.flatnonzero(blocks.first >= 0)
        found[blocks.first[rows, None] + np.arange(entity.tangent)] = one[rows]
    return found


def code_products(problem: Problem, v: Floats) -> Floats:
    """(size,) ``J'J v`` of residuals by own code."""
    trash = problem.structure.plan.trash
    wide = np.concatenate([v, np.zeros(trash)])
    found = np.zeros(problem.size + trash)
    for number in problem.hooks.items if problem.hooks is not None else ():
        group = problem.layout.groups[number]
        entries = np.asarray(problem.evaluation.group_rows(number)[1], dtype=np.float64)
        at = problem.structure.placements[number].gradient_at
        change = np.zeros((len(entries), group.residuals))
        for k, (residual, use, tangent) in enumerate(group.jacobian):
            change[:, residual] += entries[:, k] * wide[at[:, use] + tangent]
        for k, (residual, use, tangent) in enumerate(group.jacobian):
            np.add.at(found, at[:, use] + tangent, entries[:, k] * change[:, residual])
    return found[: problem.size]


# --- programs ---------------------------------------------------------------------------------


def _program(
    layout: Layout, group: Group, kind: str, columns: Iterable[Place] | None, states: bool
) -> _Program:
    """The program of a group, made once for what is asked."""
    places = None if columns is None else frozenset(columns)
    raws = tuple(k for k, raw in enumerate(group.raw) if _is_asked(group, raw, places))
    known = group.__dict__.setdefault("adjoints", {})
    key = kind, raws, states
    if key not in known:
        known[key] = _made(layout, group, kind, raws, states)
    found: _Program = known[key]
    return found


def _is_asked(group: Group, raw: Raw, places: frozenset[Place] | None) -> bool:
    """Whether derivatives by a raw input are asked: of data, or of a sum over rows of it."""
    if raw.column.endswith("?"):
        return False
    if places is None:
        return True
    if raw.column == CONSTANT:
        return _CONSTANT_PLACE in places
    table = group.slots[raw.slot].table
    if "#" not in raw.column:
        return (table, raw.column) in places
    return any(
        _is_asked_of_total(total.slots, inner, places)
        for total in group.totals
        if (total.owner, total.name) == (table, raw.column)
        for inner in total.raw
    )


def _is_asked_of_total(slots: Any, raw: Raw, places: frozenset[Place]) -> bool:
    # A total of a total is asked without a look at what that one reads.
    return "#" in raw.column or (slots[raw.slot].table, raw.column) in places


def _made(layout: Layout, group: Group, kind: str, raws: tuple[int, ...], states: bool) -> _Program:
    graph = Graph()
    moving = [graph.input(("state", k)) for k in range(len(group.states))]
    data = [graph.input(("raw", k)) for k in range(len(group.raw))]
    natives = _natives(layout)
    lanes = read_tape(graph, group.prepare, data, natives)
    records = _records(group)
    for k in records:
        lanes[k] = graph.input(("record", k))
    flags = []
    if group.moving_guard is not None:
        flags = [graph.input("acting")]
        lanes[group.data_count - 1] = flags[0]
    outputs = read_tape(graph, group.tape, [*moving, *lanes], natives)
    residuals, entries = outputs[: group.residuals], outputs[group.residuals :]
    weights: list[tuple[int, int]]
    if kind == "value":
        weights = [(k, -1) for k in range(group.residuals)]
        factors = [graph.input(weight) for weight in weights]
    else:
        weights = sorted({(use, tangent) for _, use, tangent in group.jacobian})
        factors = [graph.const(0.0)] * group.residuals
        for (residual, use, tangent), entry in zip(group.jacobian, entries, strict=True):
            term = graph.op("mul", entry, graph.input((use, tangent)))
            factors[residual] = graph.op("add", factors[residual], term)
    total = graph.const(0.0)
    for residual, factor in zip(residuals, factors, strict=True):
        total = graph.op("add", total, graph.op("mul", residual, factor))
    wanted = [*(data[k] for k in raws), *(moving if states else ())]
    slopes = gradient(graph, total, wanted)
    zero = graph.const(0.0)
    first = len(raws)
    kept_raws = [k for k in range(first) if slopes[k] != zero]
    kept_states = [k for k in range(len(moving) * states) if slopes[first + k] != zero]
    kept = [*(slopes[k] for k in kept_raws), *(slopes[first + k] for k in kept_states)]
    keys = [("state", k) for k in range(len(moving))]
    keys += [("raw", k) for k in range(len(data))]
    inputs: list[Any] = [*keys, *weights, *(("record", k) for k in records)]
    inputs += ["acting"] if flags else []
    return _Program(
        graph.tape(kept, inputs=inputs),
        tuple(weights),
        tuple(raws[k] for k in kept_raws),
        tuple(kept_states),
    )


def _records(group: Group) -> list[int]:
    """Lane inputs that hold records of look-ups: the interval of an argument has no derivative."""
    return [k for one in group.look_ups for k in range(one.first + 1, one.first + 1 + one.record)]


def _natives(layout: Layout) -> dict[str, Prescribed]:
    """Native functions of a model, differentiated as the model says."""
    found: dict[str, Prescribed] = {}

    def partials(function: Function, graph: Graph, args: Sequence[int]) -> list[int]:
        assert function.partials is not None
        return read_tape(graph, function.partials, args, found)

    for function in layout.functions:
        if function.native:
            found[function.name] = Prescribed(function.name, True, partial(partials, function))
    return found


def _retraction(entity: Entity) -> tuple[Tape, tuple[int, ...]]:
    """Derivatives by a step of zero, of a weighted sum of the state; and the state with weights.

    Inputs are the stored scalars, then the weights.
    """
    found: tuple[Tape, tuple[int, ...]] | None = entity.__dict__.get("retraction")
    if found is None:
        graph = Graph()
        stored = [graph.input(("stored", k)) for k in range(entity.stored)]
        step = [graph.input(("step", k)) for k in range(entity.tangent)]
        outputs = read_tape(graph, entity.refresh, [*stored, *step])
        moving = graph.depends(step)
        wanted = tuple(k for k, node in enumerate(outputs) if node in moving)
        total = graph.const(0.0)
        for k in wanted:
            term = graph.op("mul", graph.input(("weight", k)), outputs[k])
            total = graph.op("add", total, term)
        slopes = gradient(graph, total, step)
        still = graph.copy(slopes, graph, dict.fromkeys(step, graph.const(0.0)))
        inputs: list[Any] = [("stored", k) for k in range(entity.stored)]
        inputs += [("weight", k) for k in wanted]
        found = entity.__dict__["retraction"] = (graph.tape(still, inputs=inputs), wanted)
    return found


# --- evaluation -------------------------------------------------------------------------------


def _nothing(problem: Problem) -> Derivatives:
    states = [
        np.zeros((len(one), entity.state))
        for one, entity in zip(problem.states, problem.layout.entities, strict=True)
    ]
    return Derivatives({}, states)


def _run(
    problem: Problem,
    number: int,
    program: _Program,
    weights: Sequence[Floats],
    found: Derivatives,
    varied: tuple[Group, Floats] | None = None,
    chosen: NDArray[np.int64] | None = None,
) -> None:
    """Add the derivatives of one group, instance by instance, to the rows that it reads.

    Parameters
    ----------
    varied : the group with a constant as an input, and the values of this
    chosen : instances, by their number; None: all
    """
    structure = problem.structure
    group = problem.layout.groups[number] if varied is None else varied[0]
    active, ways = structure.active[number], structure.slot_rows[number]
    at = structure.placements[number].rows
    acting = np.asarray(problem.evaluation.acting(number), dtype=np.float64)
    lanes: list[Any] = []
    if group.look_ups:
        columns = problem.group_inputs(number, problem.states)[len(group.states) :]
        lanes = [columns[k] for k in _records(group)]
    sums = [0.0] * len(program.raws)
    count = len(active) if chosen is None else len(chosen)
    for begin in range(0, count, _AT_ONCE):
        end = min(begin + _AT_ONCE, count)
        part = slice(begin, end) if chosen is None else chosen[begin:end]
        rows = [way[part] for way in ways]
        inputs = [
            np.asarray(problem.states[group.uses[u].entity][at[part, u], offset], dtype=np.float64)
            for u, offset in group.states
        ]
        if varied is None:
            inputs += gather_all(problem.store, group.slots, rows, group.raw_columns)
        else:
            inputs += _with_constant(problem, *varied, rows)
        inputs += [weight[part] for weight in weights]
        inputs += [np.asarray(lane[part], dtype=np.float64) for lane in lanes]
        if group.moving_guard is not None:
            inputs.append(acting[part])
        outputs = _outputs(program.tape, inputs, end - begin, problem.natives)
        for k, number_of_raw in enumerate(program.raws):
            raw = group.raw[number_of_raw]
            table = group.slots[raw.slot].table
            if table == "" or raw.column == CONSTANT:
                sums[k] += float(outputs[k].sum())
            else:
                _add(
                    problem,
                    found.data,
                    (table, raw.column),
                    raw.component,
                    rows[raw.slot],
                    outputs[k],
                )
        for k, number_of_state in enumerate(program.states, len(program.raws)):
            use, offset = group.states[number_of_state]
            target = found.states[group.uses[use].entity]
            target[:, offset] += np.bincount(at[part, use], outputs[k], len(target))
    for k, number_of_raw in enumerate(program.raws):
        raw = group.raw[number_of_raw]
        if group.slots[raw.slot].table == "" or raw.column == CONSTANT:
            place = "", raw.column
            _add(problem, found.data, place, raw.component, np.zeros(1, int), np.array([sums[k]]))


def _with_constant(
    problem: Problem, group: Group, values: Floats, rows: list[NDArray[Any]]
) -> list[Any]:
    """All raw inputs of a group with a constant as an input."""
    others = [raw for raw in group.raw if raw.column != CONSTANT]
    read = iter(gather_all(problem.store, group.slots, rows, columns_of(others)))
    return [
        np.asarray(values[raw.component]) if raw.column == CONSTANT else next(read)
        for raw in group.raw
    ]


def _add(
    problem: Problem,
    data: dict[Place, Floats],
    place: Place,
    component: int,
    rows: NDArray[Any],
    values: Floats,
) -> None:
    table = place[0]
    size = problem.store.tables[table].size
    if place not in data:
        data[place] = np.zeros((size, _width(problem, place)))
    if len(rows) and rows.min() < 0:  # a null ref that a branch does not read
        rows, values = rows[rows >= 0], values[rows >= 0]
    data[place][:, component] += np.bincount(rows, values, size)


def _width(problem: Problem, place: Place) -> int:
    table, column = place
    if "#" in column:
        return len(problem.layout.totals[place].tape.outputs)
    return prod(problem.store.tables[table].column(column).shape[1:])


def _spread_totals(problem: Problem, data: dict[Place, Floats]) -> None:
    """Replace derivatives by sums over rows by those by what the rows read."""
    while places := [place for place in data if "#" in place[1]]:
        for place in places:
            _spread_total(problem, place, data.pop(place), data)


def _spread_total(
    problem: Problem, place: Place, by_sum: Floats, data: dict[Place, Floats]
) -> None:
    store: StoreLike = problem.store
    total = problem.layout.totals[place]
    known: dict[str, Tape] = problem.layout.__dict__.setdefault("adjoints_of_totals", {})
    asked = [k for k, raw in enumerate(total.raw) if not raw.column.endswith("?")]
    name = f"{place[0]}.{place[1]}"
    if name not in known:
        graph = Graph()
        raws = [graph.input(("raw", k)) for k in range(len(total.raw))]
        outputs = read_tape(graph, total.tape, raws)
        whole = graph.const(0.0)
        for k, output in enumerate(outputs):
            term = graph.op("mul", graph.input(("weight", k)), output)
            whole = graph.op("add", whole, term)
        slopes = gradient(graph, whole, [raws[k] for k in asked])
        keys: list[Any] = [("raw", k) for k in range(len(raws))]
        keys += [("weight", k) for k in range(len(outputs))]
        known[name] = graph.tape(slopes, inputs=keys)
    table = store.tables[total.collection]
    rows = np.arange(table.size, dtype=np.int64)
    walker = Walker(store, total.collection, rows, True)
    ways = [walker.rows(slot) for slot in total.slots]
    inputs = gather_all(store, total.slots, ways, columns_of(total.raw))
    inputs += list(by_sum[np.asarray(table.parent_rows(), dtype=np.int64)].T)
    slopes_of_rows = _outputs(known[name], inputs, table.size)
    for values, k in zip(slopes_of_rows, asked, strict=True):
        raw = total.raw[k]
        path = total.slots[raw.slot].table
        _add(problem, data, (path, raw.column), raw.component, ways[raw.slot], values)


def _outputs(tape: Tape, inputs: Sequence[Any], n: int, natives: Any = None) -> Floats:
    """(outputs, n) of a tape, also where no input is a column."""
    if not tape.natives:
        natives = None
    found = columns_of_tape(tape, inputs, np.float64, natives)[0]
    if found.shape[1] == n:
        return found
    return np.repeat(found, n, axis=1)
