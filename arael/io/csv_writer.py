"""CSV writer: one collection, in the format of `csv_reader`."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator
from typing import Any

import numpy as np

from arael.io.columns import of_component, scalar_names
from arael.io.csv_reader import choose
from arael.io.json_writer import fixed_flags, own_bounds, refuse_not_finite, shortest
from arael.io.refs import refs_as_data
from arael.runtime.layout import Column
from arael.runtime.store import Store, Table
from arael.runtime.store.bounds import ENDS
from arael.runtime.store.schema import Leaf


def dump(store: Store, name: str, collection: str | None) -> bytes:
    """Return one collection of a store as CSV.

    Raises
    ------
    AraelError
        E0713 no such collection, E0705 where a number is NaN or infinite, E0709 for a stale ref.
    """
    table = choose(store, name, collection)
    header, columns = [], []
    for leaf in table.fields.leaves():
        if leaf.column.role == "constraint_index":
            continue
        for title, cells in _cells(table, leaf):
            header.append(title)
            columns.append(cells)
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(zip(*columns, strict=True))
    return text.getvalue().encode()


def _cells(table: Table, leaf: Leaf) -> Iterator[tuple[str, list[Any]]]:
    """Titles and cells of one field: a column for each of its scalars, empty where absent."""
    column, path = leaf.column, leaf.path
    there = table.present(path).tolist()
    if column.role == "ref":
        values = refs_as_data(table, column)
        yield path, ["" if v is None else v for v in values]
        return
    array = table.column(path)
    if column.kind == "real":
        refuse_not_finite(table, leaf, array, table.present(path))
        array = shortest(array)
    if column.kind == "bool":
        array = np.where(array, "true", "false").astype(object)
    for title, index in scalar_names(column):
        scalars: Any = array
        for axis in index:
            scalars = scalars[:, axis]
        part = scalars.tolist()
        yield title, [v if t else "" for v, t in zip(part, there, strict=True)]
    if column.role == "param":
        yield from _own_cells(table, column)


def _own_cells(table: Table, column: Column) -> Iterator[tuple[str, list[Any]]]:
    """Flags and bounds of a parameter: of its components, where these have their own."""
    fixed = fixed_flags(table, column)
    if fixed.any():
        parts = [(column.path, ())] if fixed.ndim == 1 else scalar_names(column)
        for title, index in parts:
            flags = of_component(fixed, index).tolist()
            yield f"{title}.fixed", ["true" if f else "false" for f in flags]
    for end in ENDS:
        own, differs = own_bounds(table, column, end)
        if not differs.any():
            continue
        for title, index in scalar_names(column):
            bounds = of_component(own, index).tolist()
            yield (
                f"{title}.{end}",
                [b if d else "" for b, d in zip(bounds, differs.tolist(), strict=True)],
            )
