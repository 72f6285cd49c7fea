"""Names of columns in files with one column per field (NPZ) or per scalar (CSV)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.layout import Column
from arael.runtime.store import Table
from arael.runtime.store.manifolds import SUFFIXES, kind_of


def full_path(table: Table, path: str) -> str:
    """Path of a field from the root: ``poses.pos``, ``landmarks.frines.pose``."""
    return f"{table.layout.path}.{path}" if table.layout.path else path


def presence_name(table: Table, optional: str) -> str:
    """Name of a presence mask: the path of a struct, ``path.present`` for a value."""
    return f"{optional}.present" if optional in table.data else optional


def offsets_name(table: Table) -> str:
    """Name of the array of row offsets by parent."""
    return f"{table.layout.path}.offsets"


def scalar_names(column: Column) -> Iterator[tuple[str, tuple[int, ...]]]:
    """Names and indices of a column's scalars: ``pos.x``; ``m[0][1]``; ``v[3]``."""
    shape, path = column.shape, column.path
    if not shape:
        yield path, ()
    elif len(shape) == 2:
        for i in range(shape[0]):
            for j in range(shape[1]):
                yield f"{path}[{i}][{j}]", (i, j)
    elif kind_of(column):
        for i, suffix in enumerate(SUFFIXES[kind_of(column)]):
            yield f"{path}{suffix}", (i,)
    elif shape[0] in (2, 3):
        for i, axis in enumerate("xyz"[: shape[0]]):
            yield f"{path}.{axis}", (i,)
    else:
        for i in range(shape[0]):
            yield f"{path}[{i}]", (i,)


def of_component(array: NDArray[Any], index: tuple[int, ...]) -> NDArray[Any]:
    """The scalars (rows,) of one component of a column."""
    at: Any = (slice(None), *index)
    return np.asarray(array[at])
