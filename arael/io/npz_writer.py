"""Writes NumPy archives; their names of arrays are those of `arael.io.npz`."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.io.columns import full_path, offsets_name, presence_name
from arael.io.json_writer import fixed_flags, own_bounds, refuse_not_finite
from arael.runtime.layout import Column
from arael.runtime.store import Store, Table
from arael.runtime.store.bounds import ENDS
from arael.runtime.store.slots import Ints

Array = NDArray[Any]


def dump(store: Store) -> bytes:
    """Return the data of a store as an archive; the same bytes for the same data.

    Raises
    ------
    AraelError
        E0705 where a number is NaN or infinite, E0709 for a stale ref, E0702 where the root lacks a
        value.
    """
    memory = io.BytesIO()
    with zipfile.ZipFile(memory, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        for name, array in arrays_of(store):
            entry = zipfile.ZipInfo(f"{name}.npy")
            entry.compress_type = zipfile.ZIP_DEFLATED
            with archive.open(entry, "w") as file:
                inner = np.asarray(array, order="C")  # keeps a count without axes
                np.lib.format.write_array(file, inner, allow_pickle=False)
    return memory.getvalue()


def arrays_of(store: Store, orders: dict[str, Ints] | None = None) -> Iterator[tuple[str, Array]]:
    """Names and arrays of all columns; raises AraelError as `dump` does.

    Parameters
    ----------
    orders : takes the rows of each table by its path, in the order in which they are written
    """
    store.check_complete()
    orders = {} if orders is None else orders
    for table in store.tables.values():
        yield from _arrays(table, orders)


def columns_by_name(table: Table) -> Iterator[tuple[str, Column]]:
    """The columns of a table by the names of their arrays."""
    for path, column in table.data.items():
        yield full_path(table, path), column


def _arrays(table: Table, orders: dict[str, Ints]) -> Iterator[tuple[str, Array]]:
    """Arrays of one table, its rows grouped by parent in the order of the parent's rows."""
    root = not table.layout.path
    order, offsets = table.grouped()
    if table.layout.parent:
        parents = orders[table.layout.parent]
        counts = np.diff(offsets)[parents]
        order = np.concatenate(
            [order[offsets[p] : offsets[p + 1]] for p in parents.tolist()] or [order]
        )
        yield offsets_name(table), np.concatenate(([0], np.cumsum(counts))).astype(np.int64)
    orders[table.layout.path] = order
    if table.layout.path and not table.layout.parent and not table.data and not table.optionals:
        yield f"{table.layout.path}.count", np.array(table.size)
    lists = {held.path: held.refs for held in table.layout.values if held.refs}
    for path, count in lists.items():
        refs = [ref_indices(table, table.data[f"{path}.{k}"])[order] for k in range(count)]
        yield full_path(table, path), np.stack(refs, axis=-1)
    for leaf in table.fields.leaves():
        column, name = leaf.column, full_path(table, leaf.path)
        if column.role == "constraint_index":
            continue
        if column.role == "ref" and leaf.path.rpartition(".")[0] in lists:
            continue
        if column.role == "ref":
            yield name, ref_indices(table, column)[order]
            continue
        array = table.column(leaf.path)
        if column.kind == "real":
            refuse_not_finite(table, leaf, array, table.present(leaf.path))
        if column.kind == "string":
            array = array.astype(np.str_)
        yield name, array[0] if root else array[order]
        if column.role == "param":
            fixed = fixed_flags(table, column)
            if fixed.any():
                yield f"{name}.fixed", fixed[order]
            for end in ENDS:
                own, differs = own_bounds(table, column, end)
                if differs.any():
                    yield f"{name}.{end}", own[0] if root else own[order]
    for path in table.optionals:
        if path not in table.data or table.data[path].role != "ref":
            name = full_path(table, presence_name(table, path))
            yield name, table.column(f"{path}?")[order]


def ref_indices(table: Table, column: Column) -> Ints:
    """Return indices of refs within their target collections; -1 where absent."""
    assert column.target is not None
    target = table.store.tables[column.target.table]
    rows = table.target_rows(column.path)
    if not target.size:
        return rows
    return np.where(rows >= 0, target.index_in_parent()[np.maximum(rows, 0)], -1)
