"""The first rows of a model's data, as the arrays that exported functions read."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.exporting.c_functions import ConstraintFunction, Functions
from arael.exporting.rows import Rows
from arael.model import Model
from arael.runtime.evaluation.states import stored_scalars
from arael.runtime.layout import Raw, Slot
from arael.runtime.store.access import StoreLike, gather
from arael.solving import problem_of

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Samples:
    """Arguments of a function for some instances of its constraint.

    Attributes
    ----------
    rows : (n,) rows of the constraint's table
    states : (n, size) for each of its parameter sets
    data : (n, size) for each of its data arrays
    """

    rows: NDArray[np.int64]
    states: tuple[Floats, ...]
    data: tuple[Floats, ...]


def samples_of(functions: Functions, model: Model, first: int | None = None) -> list[Samples]:
    """Arguments of each function at the model's values, for its `first` active instances, or all.

    Parameters
    ----------
    functions : of the model's layout
    model : with data; instances are active as at its values
    first : how many instances

    Raises
    ------
    AraelError, SolveError
        The data is not complete, as before a solve.
    """
    model._store.check_complete()
    structure = problem_of(model).structure
    layout, store = functions.layout, model._store
    numbers = {(g.label, g.table, g.prefix): n for n, g in enumerate(layout.groups)}
    found = []
    for function in functions.constraints:
        group = function.group
        number = numbers[group.label, group.table, group.prefix]
        rows = structure.active[number][:first]
        slots = [np.asarray(ways)[:first] for ways in structure.slot_rows[number]]
        found.append(_samples(functions, function, store, rows, slots))
    return found


def model_values(functions: Functions, rows: Rows, model: Model) -> dict[str, NDArray[Any]]:
    """All rows of a model as the arrays that exported programs read, by their names in C.

    Parameters ``pose`` (rows, stored), ``pose_fixed`` (rows, tangent), ``edges_count``, refs
    ``edges_a`` (rows,), data ``edge_data`` (rows, scalars).
    """
    model._store.check_complete()
    store = model._store
    problem = problem_of(model)
    problem.check_start()
    system = problem.structure.system
    values: dict[str, NDArray[Any]] = {}
    for one in functions.used:
        values[one.stored.name] = stored_scalars(store, one.entity, np.dtype(np.float64))
        fixed = ~system.blocks[one.number].free
        values[f"{one.stored.name}_fixed"] = fixed.astype(int)
    for path in rows.tables:
        table = store.tables[path]
        if path:
            values[f"{rows.names[path]}_count"] = np.array(table.size)
        for (owner, step), name in rows.refs.items():
            if owner == path:
                parent = step.kind == "parent"
                targets = table.parent_rows() if parent else table.target_rows(step.ref)
                values[name] = np.asarray(targets).astype(int)
        array = functions.arrays.data.get(path)
        if array is not None:
            all_rows = [np.arange(table.size)]
            columns = [
                np.broadcast_to(
                    gather(store, (Slot((), path),), all_rows, Raw(0, part.name, k)), table.size
                )
                for part in array.parts
                for k in range(part.count)
            ]
            values[array.name] = np.stack(columns, axis=1)
    return values


def _samples(
    functions: Functions,
    function: ConstraintFunction,
    store: StoreLike,
    rows: NDArray[np.int64],
    slots: list[NDArray[np.int64]],
) -> Samples:
    group = function.group
    states = [
        stored_scalars(store, one.entity, np.dtype(np.float64))[slots[state.slot]]
        for state, one in zip(function.states, function.sets, strict=True)
    ]
    data = {one.slot: np.zeros((len(rows), one.array.size)) for one in function.data}
    for raw in (*group.raw, *group.guard_raw):
        if raw.slot in data:
            table = group.slots[raw.slot].table
            at = functions.arrays.offset(table, raw.column, raw.component)
            data[raw.slot][:, at] = gather(store, group.slots, slots, raw)
    return Samples(rows, tuple(states), tuple(data.values()))
