"""Stored parameters in the form kernels read, and the way back into the store."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.access import Array, StoreLike
from arael.runtime.layout import Entity
from arael.runtime.system import System


def stored_scalars(store: StoreLike, entity: Entity, dtype: np.dtype[Any]) -> Array:
    """(rows, stored) stored scalars of an entity, from the columns of its table."""
    table = store.tables[entity.table]
    found = np.zeros((table.size, entity.stored), dtype=dtype)
    for use in entity.params:
        values = np.asarray(table.column(use.column)).reshape(table.size, use.stored)
        found[:, use.stored_start : use.stored_start + use.stored] = values
    return found


def write_back(store: StoreLike, system: System, states: list[Array]) -> None:
    """Put the stored scalars of `states` into the columns: of parameters that moved, no others."""
    for entity, blocks, state in zip(store.layout.entities, system.blocks, states, strict=True):
        table = store.tables[entity.table]
        for use in entity.params:
            moves = blocks.free[:, use.tangent_start : use.tangent_start + use.tangent]
            moved = moves.any(axis=1)
            column = table.column(use.column)
            values = state[: table.size, use.stored_start : use.stored_start + use.stored]
            values = _inside(store, entity, use.column, values)
            column[moved] = values.reshape(column.shape)[moved]


def _inside(store: StoreLike, entity: Entity, column: str, values: Array) -> Array:
    """Values within bounds to the last bit; a step onto a bound may end a rounding beyond."""
    param = store.layout.table(entity.table).column(column).param
    assert param is not None
    for k, low in enumerate(param.low):
        if low is not None:
            values[:, k] = np.maximum(values[:, k], low)
    for k, high in enumerate(param.high):
        if high is not None:
            values[:, k] = np.minimum(values[:, k], high)
    return values


def solved_values(system: System, states: list[Array]) -> NDArray[np.float64]:
    """Stored scalars of every row that is solved for, in order of the system."""
    parts = [
        state[: len(blocks.first)][blocks.first >= 0, : entity.stored].ravel()
        for entity, blocks, state in zip(system.layout.entities, system.blocks, states, strict=True)
    ]
    return np.concatenate(parts).astype(np.float64) if parts else np.zeros(0)
