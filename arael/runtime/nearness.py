"""Rows that look-ups of parameters read: those near the arguments, found from the values stored."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from arael.runtime.evaluation.instances import gathered
from arael.runtime.evaluation.look_up_tables import LookUpTable, look_up_tables
from arael.runtime.evaluation.states import stored_scalars
from arael.runtime.layout import Entity, Group
from arael.runtime.machine.programs import evaluate
from arael.runtime.store.access import Array, Ints, StoreLike

if TYPE_CHECKING:
    from arael.runtime.machine.compiled import NativeTable
    from arael.runtime.problem import Problem


def near_rows(
    store: StoreLike,
    group: Group,
    active: Ints,
    slot_rows: list[Ints],
    natives: NativeTable | None = None,
) -> dict[int, Ints]:
    """By slot, the rows that look-ups of parameters read in each active instance.

    Parameters
    ----------
    slot_rows : rows of all slots; of those that are asked for anything

    Raises
    ------
    SolveError
        E1019: a collection does not have the rows for a look-up.
    """
    dtype = np.dtype(np.float32 if store.layout.precision == "f32" else np.float64)
    tables = look_up_tables(store, group, slot_rows, dtype)
    arguments = _arguments(store, group, active, slot_rows, dtype, natives)
    found: dict[int, Ints] = {}
    for number in group.near:
        rows = tables[number].near[tables[number].intervals_at(arguments[number])]
        for k, slot in enumerate(group.look_ups[number].rows):
            found[slot] = rows[:, k].astype(np.int64)
    return found


def _arguments(
    store: StoreLike,
    group: Group,
    active: Ints,
    slot_rows: list[Ints],
    dtype: np.dtype[Any],
    natives: NativeTable | None,
) -> list[Array]:
    """(instances,) the arguments of all look-ups at the values stored."""
    assert group.arguments is not None
    entities = store.layout.entities
    read = {args[0] for op, args in zip(group.arguments.ops, group.arguments.args, strict=True)
            if op == "input"}  # fmt: skip
    data = gathered(store, group, active, slot_rows, dtype, natives)
    inputs: list[Any] = [0.0] * len(group.states)
    for number in sorted(read & set(range(len(group.states)))):
        use, offset = group.states[number]
        rows = slot_rows[group.uses[use].slot]
        state = _state(store, entities[group.uses[use].entity], dtype)
        inputs[number] = np.broadcast_to(state[offset], len(state[0]))[rows]
    inputs += [*data.data.T, *data.uniform]
    found = evaluate(group.arguments, inputs, dtype, natives)
    return [np.broadcast_to(one, len(active)) for one in found]


def _state(store: StoreLike, entity: Entity, dtype: np.dtype[Any]) -> list[Array]:
    """Scalars of the state of an entity, each (rows,), at the values stored."""
    stored = stored_scalars(store, entity, dtype)
    if entity.state == entity.stored:
        return list(stored.T)
    still = [np.zeros(len(stored), dtype=dtype)] * entity.tangent
    return evaluate(entity.refresh, [*stored.T, *still], dtype)


def same_near_rows(
    store: StoreLike,
    group: Group,
    active: Ints,
    slot_rows: list[Ints],
    natives: NativeTable | None,
) -> bool:
    """Whether the values stored lead to these rows."""
    found = near_rows(store, group, active, slot_rows, natives)
    return all(np.array_equal(rows, slot_rows[slot]) for slot, rows in found.items())


def has_moved(problem: Problem) -> bool:
    """Whether an argument has left the interval of the rows that its instance reads."""
    for number, group in enumerate(problem.layout.groups):
        if not group.moves_rows or not len(problem.structure.active[number]):
            continue
        arguments = problem.arguments(number)
        rows = problem.structure.slot_rows[number]
        tables: list[LookUpTable] = list(problem.instances[number].tables)
        for k in group.near:
            slot = group.look_ups[k].rows[(group.look_ups[k].order - 1) // 2]
            intervals = tables[k].intervals_at(arguments[k])
            if not np.array_equal(tables[k].interval_of[rows[slot]], intervals):
                return True
    return False
