"""Parquet and Arrow (Feather) files by pyarrow: one collection, columns as in CSV files.

One column for each scalar, ``pos.x``, ``att.w``, ``m[0][1]``; refs as indices; ``pos.fixed`` or
``pos.x.fixed`` where something is fixed; ``pos.x.low`` where a row has bounds of its own, infinite
where open. Null is an absent optional, a null ref, or a bound of the model.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import AraelError
from arael.io import frames
from arael.io.columns import of_component, scalar_names
from arael.io.csv_reader import choose
from arael.io.files import too_large
from arael.io.json_writer import fixed_flags, own_bounds, refuse_not_finite
from arael.io.npz_writer import ref_indices
from arael.io.packages import required
from arael.runtime.layout import Column
from arael.runtime.store import Store, Table
from arael.runtime.store.bounds import ENDS
from arael.runtime.store.messages import error, shorten
from arael.runtime.store.schema import Leaf

Array = NDArray[Any]
MAGIC = {b"PAR1": "parquet", b"ARROW1": "arrow"}
"""First bytes of a file -> its format."""
WORDS = {"parquet": "Parquet", "arrow": "Arrow"}
_BOUNDS = tuple(f".{end}" for end in ENDS)
CELL = 8
"""Bytes of one cell in memory, for the limit before anything is unpacked."""


def read(
    store: Store, content: bytes, name: str, format: str, collection: str | None, limit: int
) -> None:
    """Replace the rows of one collection by those of a Parquet or Arrow file.

    Raises
    ------
    AraelError
        E0725 without pyarrow; E0711 another format or damaged; E0713 no such collection; E0714 too
        large when unpacked; E0701 an unknown column, E0702 a missing one, E0718 one twice; E0703
        wrong type, E0705 not finite, E0706 does not fit, E0708 ref out of range, E0730 bounds
        that leave no value. The store is then unchanged.
    """
    pa = required("pyarrow", name, WORDS[format])
    table = choose(store, name, collection)
    columns = _unpack(pa, content, name, format, limit)
    frame = _Frame(pa, columns, name)
    kept = [(t, t.snapshot()) for t in table.with_descendants()]
    try:
        count, values, _ = frames.columns_of(frame, table, table.fields)
        table.clear()
        table.extend(count, **values)
    except AraelError as failure:
        for changed, state in kept:
            changed.restore(state)
        found = [
            d if d.origin.startswith(name) else replace(d, origin=f"{name}: {d.origin}")
            for d in failure.diagnostics
        ]
        raise AraelError(found) from None


def _unpack(pa: Any, content: bytes, name: str, format: str, limit: int) -> Any:
    """The file as a table of pyarrow, if it is within the limit."""
    try:
        buffer = pa.BufferReader(content)
        if format == "parquet":
            file = required("pyarrow.parquet", name, WORDS[format]).ParquetFile(buffer)
            if file.metadata.num_rows * file.metadata.num_columns * CELL > limit:
                raise too_large(name, limit)
            return _validated(file.read())
        ipc = required("pyarrow.ipc", name, WORDS[format])
        reader = ipc.open_file(buffer)
        batches, size = [], 0
        for number in range(reader.num_record_batches):
            batches.append(_validated(reader.get_batch(number)))
            size += batches[-1].nbytes
            if size > limit:
                raise too_large(name, limit)
        return _validated(pa.Table.from_batches(batches, reader.schema))
    except AraelError:
        raise
    except (pa.ArrowException, OSError, ValueError):
        what = f"not {'an Arrow' if format == 'arrow' else 'a Parquet'} file, or a damaged one"
        raise error("E0711", what, name) from None


def _validated(rows: Any) -> Any:
    """Rows of pyarrow whose offsets, indices and texts are checked, before anything reads them."""
    rows.validate(full=True)
    if not all(name.isprintable() for name in rows.schema.names):
        raise ValueError("a title with control characters")
    return rows


class _Frame:
    """A table of pyarrow with the interface that `frames.columns_of` reads."""

    def __init__(self, pa: Any, table: Any, name: str) -> None:
        self._pa, self._table, self._name = pa, table, name
        self.columns: list[str] = list(table.column_names)
        self.shape = (table.num_rows, table.num_columns)

    def __getitem__(self, name: str) -> Array:
        types, cells = self._pa.types, self._table.column(name)
        if types.is_dictionary(cells.type):
            cells = cells.cast(cells.type.value_type)
        kind = cells.type
        known = (types.is_boolean, types.is_integer, types.is_floating)
        texts = (types.is_string, types.is_large_string)
        if not any(test(kind) for test in (*known, *texts)):
            text = f"expected numbers, bools or strings, found {shorten(str(kind))}"
            raise error("E0703", text, f"{self._name}: {shorten(name)}")
        gaps = np.asarray(cells.is_null())
        if types.is_floating(kind):
            values = np.asarray(cells.fill_null(0.0), np.float64)
            is_bound = name.endswith(_BOUNDS)
            bad = np.flatnonzero(np.isnan(values) if is_bound else ~np.isfinite(values))
            if len(bad):
                place = f"{self._name}: {shorten(name)} row {bad[0]}"
                what = (
                    "number, found NaN" if is_bound else "finite number, found NaN or an infinity"
                )
                raise error("E0705", f"expected a {what}", place)
        if not gaps.any():
            return np.asarray(cells)
        found = np.empty(len(gaps), object)
        found[:] = cells.to_pylist()
        return found


def dump(store: Store, name: str, format: str, collection: str | None) -> bytes:
    """Return one collection of a store as Parquet or Arrow (Feather version 2).

    Raises
    ------
    AraelError
        E0725 without pyarrow, E0713 no such collection, E0705 NaN or infinite, E0709 a stale ref.
    """
    pa = required("pyarrow", name, WORDS[format])
    table = choose(store, name, collection)
    columns: dict[str, Any] = {}
    for leaf in table.fields.leaves():
        if leaf.column.role != "constraint_index":
            for title, (values, there) in _cells(table, leaf).items():
                columns[title] = pa.array(values, mask=~there)
    rows, sink = pa.table(columns), pa.BufferOutputStream()
    if format == "parquet":
        required("pyarrow.parquet", name, WORDS[format]).write_table(rows, sink)
    else:
        with required("pyarrow.ipc", name, WORDS[format]).new_file(sink, rows.schema) as file:
            file.write_table(rows)
    content: bytes = sink.getvalue().to_pybytes()
    return content


def _cells(table: Table, leaf: Leaf) -> dict[str, tuple[Array, NDArray[np.bool_]]]:
    """Values of each scalar of a field, and where they are present."""
    column, path = leaf.column, leaf.path
    there = np.asarray(table.present(path))
    if column.role == "ref":
        indices = ref_indices(table, column)
        return {path: (indices, there & (indices >= 0))}
    array = table.column(path)
    if column.kind == "real":
        refuse_not_finite(table, leaf, array, there)
    found: dict[str, tuple[Array, NDArray[np.bool_]]] = {}
    for title, index in scalar_names(column):
        found[title] = (np.ascontiguousarray(of_component(array, index)), there)
    if column.role == "param":
        found |= _own_cells(table, column)
    return found


def _own_cells(table: Table, column: Column) -> dict[str, tuple[Array, NDArray[np.bool_]]]:
    """Flags and bounds of a parameter: of its components, where these have their own."""
    found: dict[str, tuple[Array, NDArray[np.bool_]]] = {}
    fixed, every = fixed_flags(table, column), np.ones(table.size, np.bool_)
    if fixed.any():
        for title, index in [(column.path, ())] if fixed.ndim == 1 else scalar_names(column):
            found[f"{title}.fixed"] = (np.ascontiguousarray(of_component(fixed, index)), every)
    for end in ENDS:
        own, differs = own_bounds(table, column, end)
        if differs.any():
            for title, index in scalar_names(column):
                bounds = np.ascontiguousarray(of_component(own, index))
                found[f"{title}.{end}"] = (bounds, differs)
    return found
