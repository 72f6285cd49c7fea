"""Stored parameters in the form kernels read, and the way back into the store."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.arguments import wrong_argument
from arael.runtime.bounds import keep_inside
from arael.runtime.layout import Entity, ParamUse
from arael.runtime.store.access import Array, StoreLike
from arael.runtime.store.compiled import join_columns, solved_scalars, split_columns
from arael.runtime.store.messages import error
from arael.runtime.store.values import convert
from arael.runtime.system import EntityBlocks, System, row_name


def stored_scalars(store: StoreLike, entity: Entity, dtype: np.dtype[Any]) -> Array:
    """(rows, stored) stored scalars of an entity, from the columns of its table."""
    table = store.tables[entity.table]
    found = np.zeros((table.size, entity.stored), dtype=dtype)
    join_columns(table.columns(entity.columns), entity.stored_starts, found)
    return found


def write_back(store: StoreLike, system: System, states: list[Array]) -> None:
    """Put the stored scalars of `states` into the columns: of parameters that moved, no others."""
    keep_inside(system, states)
    for entity, blocks, state in zip(store.layout.entities, system.blocks, states, strict=True):
        table = store.tables[entity.table]
        split_columns(
            state,
            entity.stored_starts,
            table.columns(entity.columns),
            None if blocks.every else blocks.free,
            *entity.written_by,
        )
        table.written()


def _moved(entity: Entity, use: ParamUse, blocks: EntityBlocks) -> NDArray[np.bool_]:
    """(rows,) where a solve changes the scalars of `use`.

    An update may set what no step moves: what is carried along, and what is fixed.
    """
    if use.column in entity.updated:
        return np.asarray(blocks.free.any(axis=1))
    free = blocks.free[:, use.tangent_start : use.tangent_start + use.tangent]
    return np.asarray(free[:, 0] if use.tangent == 1 else free.any(axis=1))


def solved_values(system: System, states: list[Array]) -> NDArray[np.float64]:
    """Stored scalars of every row that is solved for, in order of the system."""
    return solved_scalars(
        states,
        [blocks.free for blocks in system.blocks],
        [entity.stored for entity in system.layout.entities],
    )


def put_values(store: StoreLike, system: System, values: Any) -> None:
    """Write stored scalars in order of the system (`solved_values`) into the columns.

    Only parameters that move are written, all of them or, after an error, none.

    Raises
    ------
    AraelError
        E0704 the number of scalars differs; E0705 one is not finite; E0721 four of them are not a
        rotation, or three not a direction.
    """
    try:
        given = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise wrong_argument(
            "deserialize",
            "x",
            "an array of numbers",
            values,
            "take the vector from `serialize()` or `Result.x` of this model",
        ) from None
    counts = [
        int((blocks.first >= 0).sum()) * entity.stored
        for entity, blocks in zip(system.layout.entities, system.blocks, strict=True)
    ]
    if given.shape != (sum(counts),):
        raise error(
            "E0704",
            f"expected {sum(counts)} numbers, found an array of shape {given.shape}",
            "deserialize",
            help="take the vector from `serialize()` or `Result.x` of this model: it has the "
            "stored scalars of what is solved for",
        )
    parts = np.split(given, np.cumsum(counts)[:-1])
    ready = []
    for entity, blocks, part in zip(system.layout.entities, system.blocks, parts, strict=True):
        rows = np.flatnonzero(blocks.first >= 0)
        for use in entity.params:
            ready.append(_of_parameter(store, entity, use, blocks, rows, part))
    for column, at, found in ready:
        column[at] = found
    for entity in system.layout.entities:
        store.tables[entity.table].written()


def _of_parameter(
    store: StoreLike, entity: Entity, use: ParamUse, blocks: EntityBlocks, rows: Array, part: Array
) -> tuple[Array, Array, Array]:
    """Where the values of one parameter go, and the checked values of the rows that move."""
    table = store.tables[entity.table]
    declared = store.layout.table(entity.table).column(use.column)
    column = table.column(use.column)
    moves = _moved(entity, use, blocks)[rows]
    at = rows[moves]
    state = part.reshape(len(rows), entity.stored)[moves]
    found = state[:, use.stored_start : use.stored_start + use.stored]
    found = found.reshape(len(at), *column.shape[1:])

    def name_of(i: int) -> str:
        return f"{row_name(store, entity.table, int(at[i]))}.{use.column}".removeprefix(".")

    return column, at, convert(declared, found, len(at), column.dtype, name_of, True)
