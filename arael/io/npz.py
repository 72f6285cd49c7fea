"""NumPy archives: one array per column, named by path (LANGUAGE section 10).

``poses.pos`` (N, 3); ``poses.pos.fixed`` (N,) bools if any is, (N, 3) of components;
``poses.pos.low`` and ``poses.pos.high`` (N, 3), bounds, infinite where open; ``poses.info.gps``
(N,) bools, the presence of an optional struct (``x.present`` of an optional value);
``landmarks.frines.offsets`` (parents + 1,): rows ``offsets[p]:offsets[p + 1]`` belong to parent p;
refs are indices as in JSON, -1 where absent. Root fields are arrays of one value. Nothing is
pickled.
"""

from __future__ import annotations

import io
import math
import struct
import sys
import zipfile
import zlib
from collections.abc import Iterator
from typing import Any

import numpy as np
import numpy.lib.format as npy
from numpy.typing import NDArray

from arael.diagnostics.records import AraelError
from arael.io.columns import full_path, offsets_name, presence_name
from arael.io.files import too_large
from arael.io.report import Report
from arael.runtime.layout import Column
from arael.runtime.store import Store, Table
from arael.runtime.store.bounds import (
    COMPONENTS_FIXED,
    ENDS,
    empty,
    first_empty,
    has_components,
    split_fixed,
)
from arael.runtime.store.manifolds import forms_of
from arael.runtime.store.messages import problem, shorten, suggestion
from arael.runtime.store.slots import Ints
from arael.runtime.store.values import convert

Array = NDArray[Any]
# Exceptions of zipfile for invalid archives.
DAMAGED = (
    zipfile.BadZipFile,
    zlib.error,
    struct.error,
    EOFError,
    OSError,
    RuntimeError,
    ValueError,
    LookupError,
)
MOST_ARRAYS = 20_000
MOST_ROWS = 10**12  # an axis, also of an array without elements
MAX_HEADER = 1000  # characters; NumPy writes some 60
# Rows may take more memory than the arrays of the file, since columns with a default may be
# missing: up to this much in any case, and up to this multiple of the file's arrays.
SPARE = 64 * 1024**2
RATIO = 64


def read(store: Store, content: bytes, name: str, limit: int) -> None:
    """Replace the data of `store` by that of an archive.

    Raises
    ------
    AraelError
        E0711 not an archive, E0714 too large when unpacked, E0701 unknown array, E0702 missing,
        E0703 wrong type, E0704 wrong shape or length, E0705 not finite, E0706 does not fit, E0708
        ref out of range, E0721 not a rotation.
    """
    adopt(store, _unpack(content, name, limit), name)


def adopt(store: Store, arrays: dict[str, Array], name: str) -> None:
    """Replace the data of `store` by arrays by name; raises AraelError as `read` does."""
    report = Report(name)
    fresh = store.fresh()
    report.run(lambda: _Reader(fresh, arrays, report).read())
    store.adopt(fresh)


def _unpack(content: bytes, name: str, limit: int) -> dict[str, Array]:
    """Return the arrays of the archive, if their total size is within `limit`."""
    arrays = {}
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            members = archive.infolist()
            if sum(m.file_size for m in members) > limit or len(members) > MOST_ARRAYS:
                raise too_large(name, limit)
            for member in members:
                if member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
                    raise zipfile.BadZipFile
                column = member.filename.removesuffix(".npy")
                if column in arrays:
                    message = f"the archive holds `{shorten(column)}` twice"
                    raise AraelError(problem("E0718", message, name))
                with archive.open(member) as file:
                    data = file.read(member.file_size + 1)
                arrays[column] = _array(data, member.filename, name)
    except DAMAGED:
        raise AraelError(problem("E0711", "not a NumPy archive, or a damaged one", name)) from None
    return arrays


def _array(data: bytes, member: str, name: str) -> Array:
    """Return one array of NumPy's format; its header must match its content.

    The size is compared before memory is taken: `numpy.load` allocates what the header declares.
    """
    place = f"{name}: {shorten(member.removesuffix('.npy'))}"
    file = io.BytesIO(data)
    try:
        version = npy.read_magic(file)
        header = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
        shape, fortran, dtype = header(file, max_header_size=MAX_HEADER)
    except Exception:  # of several modules that read the header: syntax, types, tokens, recursion
        message = "not an array of numbers, bools or strings"
        raise AraelError(problem("E0711", message, place)) from None
    if dtype.hasobject:
        help = "store strings as `np.array(values, dtype=str)`"
        message = "the array holds Python objects, which are not read"
        raise AraelError(problem("E0703", message, place, help=help))
    begin, count = file.tell(), math.prod(shape)
    if (
        dtype.kind not in "biufU"
        or min(shape, default=0) < 0
        or max(shape, default=0) > MOST_ROWS
        or count * dtype.itemsize != len(data) - begin
    ):
        raise AraelError(problem("E0711", "the array is truncated or damaged", place))
    flat = np.frombuffer(data, dtype, count, begin) if count else np.empty(0, dtype)
    if dtype.kind == "U" and flat.size and dtype.itemsize:
        units = flat.view(np.dtype(np.uint32).newbyteorder(dtype.byteorder))
        if (units > sys.maxunicode).any():
            raise AraelError(problem("E0711", "the text has invalid characters", place))
    return flat.reshape(shape, order="F" if fortran else "C")


class _Reader:
    def __init__(self, store: Store, arrays: dict[str, Array], report: Report) -> None:
        self.store = store
        self.arrays = arrays
        self.report = report
        self.left = max(SPARE, RATIO * sum(a.nbytes for a in arrays.values()))

    def read(self) -> None:
        for table in self.store.tables.values():
            self._split_ref_lists(table)
        self._refuse_unknown()
        for table in self.store.tables.values():
            self._table(table)
            if self.report.found:
                return
        for table in self.store.tables.values():
            self._refs(table)

    def _take(self, name: str) -> Array | None:
        return self.arrays.get(name)

    def _split_ref_lists(self, table: Table) -> None:
        """Take the elements of lists of refs, arrays (rows, refs), as columns of their own."""
        for held in table.layout.values:
            name = full_path(table, held.path)
            if not held.refs or name not in self.arrays:
                continue
            array = self.arrays.pop(name)
            if array.dtype.kind not in "iu" or array.ndim != 2 or array.shape[1] != held.refs:
                found = f"shape {array.shape} of {array.dtype}"
                self.report.add(
                    "E0704", f"expected integers of shape (rows, {held.refs}), found {found}", name
                )
                continue
            for k in range(held.refs):
                if f"{name}.{k}" in self.arrays:
                    self.report.add("E0718", f"`{name}` gives `{name}.{k}` a second time", name)
                self.arrays[f"{name}.{k}"] = array[:, k]

    def _refuse_unknown(self) -> None:
        known = {name for table in self.store.tables.values() for name in _names(table)}
        for name in self.arrays.keys() - known:
            help = suggestion(name, sorted(known))
            self.report.add("E0701", "no such column in the model", shorten(name), help=help)

    # --- rows ----------------------------------------------------------------------------------

    def _table(self, table: Table) -> None:
        owners = self._owners(table)
        count = self._count(table, owners)
        if count is None or (owners is not None and self.report.found):
            return
        self.left -= count * table.buffers.row_bytes
        if self.left < 0:
            self.report.add(
                "E0714",
                f"the file declares {count} rows, far more than it has data for",
                table.label,
                help="give at least one column of these rows",
            )
            return
        masks = self._presence(table, count)
        if self.report.found:
            return
        columns: dict[str, Array] = {f"{p}?": mask for p, mask in masks.items()}
        for path, column in table.data.items():
            if column.role == "param":
                columns |= self._fixed(table, column, count)
                columns |= self._bounds(table, column, count)
            if column.role in ("ref", "constraint_index"):
                continue
            array = self._column(table, column, count, _there(masks, path, count))
            if array is not None:
                columns[path] = array
        if self.report.found:
            return
        if table.layout.path:
            table.extend_trusted(count, owners, columns)
            return
        for path, array in columns.items():
            table.writable(path)[:] = array
        table.missing = {p for p in table.missing if table.data[p].role == "ref"}

    def _owners(self, table: Table) -> Ints | None:
        """Parent row of each row of a nested collection."""
        if not table.layout.parent:
            return None
        name = offsets_name(table)
        offsets = self._take(name)
        parents = table.parent.size
        if offsets is None:
            if any(n in self.arrays for n in _names(table)):
                self.report.add("E0702", "the offsets of a nested collection are missing", name)
            return np.empty(0, np.int64)
        if offsets.dtype.kind not in "iu" or offsets.shape != (parents + 1,):
            self.report.add(
                "E0704",
                f"expected {parents + 1} integers, found shape {offsets.shape} of {offsets.dtype}",
                name,
            )
            return np.empty(0, np.int64)
        counts = np.asarray(offsets[1:] - offsets[:-1], np.int64)
        if offsets[0] != 0 or (counts < 0).any():
            self.report.add("E0704", "offsets must begin with 0 and never decrease", name)
            return np.empty(0, np.int64)
        if int(counts.sum()) > sum(a.size for a in self.arrays.values()):
            self.report.add("E0704", "the offsets declare more rows than the file has", name)
            return np.empty(0, np.int64)
        return np.repeat(np.arange(parents), counts)

    def _count(self, table: Table, owners: Ints | None) -> int | None:
        if not table.layout.path:
            return 1
        if owners is not None:
            return len(owners)
        for path in table.data:
            array = self._take(full_path(table, path))
            if array is not None:
                if array.ndim:
                    return len(array)
                return self._not_rows(full_path(table, path))
        for path in table.optionals:
            array = self._take(full_path(table, presence_name(table, path)))
            if array is not None and array.ndim:
                return len(array)
        count = self._take(f"{table.layout.path}.count")
        if count is not None:
            good = count.dtype.kind in "iu" and count.shape == () and 0 <= count <= 10**9
            return int(count) if good else self._not_rows(f"{table.layout.path}.count")
        return 0

    def _not_rows(self, name: str) -> int | None:
        self.report.add("E0704", "expected an array with one entry a row", name)
        return None

    def _presence(self, table: Table, count: int) -> dict[str, Array]:
        masks: dict[str, Array] = {}
        for path in table.optionals:
            column = table.data.get(path)
            if column is not None and column.role == "ref":
                masks[path] = np.zeros(count, np.bool_)
                continue
            said = self._flags(full_path(table, presence_name(table, path)), count)
            if said is None:
                given = any(
                    f"{p}.".startswith(f"{path}.") and full_path(table, p) in self.arrays
                    for p in table.data
                )
                said = np.full(count, given)
            masks[path] = said
        return masks

    def _fixed(self, table: Table, column: Column, count: int) -> dict[str, Array]:
        """The flags of a parameter, (count,) or of its components."""
        path = column.path
        name = f"{full_path(table, path)}.fixed"
        given = self._take(name)
        k = column.param.tangent if column.param is not None else 0
        if given is not None and given.dtype == np.bool_ and has_components(column):
            one = count == 1 and given.shape == (k,) and not table.layout.path
            if given.shape == (count, k) or one:
                whole, some = split_fixed(given.reshape(count, k))
                return {f"{path}.fixed": whole, f"{path}.{COMPONENTS_FIXED}": some}
        flags = self._flags(name, count)
        return {f"{path}.fixed": np.zeros(count, np.bool_) if flags is None else flags}

    def _bounds(self, table: Table, column: Column, count: int) -> dict[str, Array]:
        """The bounds of a parameter that the file has."""
        found: dict[str, Array] = {}
        name = full_path(table, column.path)
        for end in ENDS:
            array = self._take(f"{name}.{end}")
            if array is None:
                continue
            where = self.report.at(f"{name}.{end}")
            try:
                checked = table.checked_bounds(column.path, end, array, count, where)
            except AraelError as failure:
                for diagnostic in failure.diagnostics:
                    self.report.take(diagnostic)
                continue
            found[f"{column.path}.{end}"] = np.broadcast_to(checked, (count, *column.shape))
        if found:
            low, high = (
                found.get(f"{column.path}.{end}", table.blank_own(column, end, count))
                for end in ENDS
            )
            row = first_empty(low, high)
            if row is not None:
                where = self.report.at(f"{name} row {row}")
                self.report.take(empty(where, column, low[row], high[row]))
        return found

    def _flags(self, name: str, count: int) -> Array | None:
        flags = self._take(name)
        if flags is None:
            return None
        if flags.dtype != np.bool_ or flags.shape not in ((count,), *([()] if count == 1 else [])):
            found = f"shape {flags.shape} of {flags.dtype}"
            self.report.add("E0704", f"expected {count} bools, found {found}", name)
            return None
        return flags.reshape(count)

    def _column(self, table: Table, column: Column, count: int, there: Array) -> Array | None:
        name = full_path(table, column.path)
        array = self._take(name)
        if array is None:
            if column.default is None and there.any():
                self.report.add("E0702", "the column is missing", name, column)
            return None
        if not table.layout.path and array.shape in forms_of(column):
            array = array[None]
        if array.shape[:1] != (count,):
            self.report.add(
                "E0704", f"expected {count} rows, found shape {array.shape}", name, column
            )
            return None
        if column.kind == "string" and array.dtype.kind == "U":
            array = array.astype(object)
        blank = table.blank_column(column.path, count)
        if not there.any():
            return blank
        rows = np.flatnonzero(there)

        def place(i: int) -> str:
            return self.report.at(f"{name} row {rows[i]}")

        try:
            blank[there] = convert(column, array[there], len(rows), table.real, place, True)
        except AraelError as failure:
            for diagnostic in failure.diagnostics:
                self.report.take(diagnostic)
            return None
        return blank

    def _refs(self, table: Table) -> None:
        for path in table._ref_order:
            if self.report.found:  # a chained ref is valid only if those it depends on are
                return
            column = table.data[path]
            name = full_path(table, path)
            given = self._take(name)
            needed = table.present(path.rpartition(".")[0]) if "." in path else None
            if given is None:
                lacking = table.size and not table.ref_is_optional(column)
                if lacking and (needed is None or needed.any()):
                    self.report.add("E0702", "the column is missing", name, column)
                continue
            if given.dtype.kind not in "iu" or given.shape != (table.size,):
                found = f"shape {given.shape} of {given.dtype}"
                self.report.add(
                    "E0704", f"expected {table.size} integers, found {found}", name, column
                )
                continue
            try:
                table.set_refs(path, np.arange(table.size), given, self.report.at(name))
            except AraelError as failure:
                for diagnostic in failure.diagnostics:
                    self.report.take(diagnostic)


def _there(masks: dict[str, Array], path: str, count: int) -> Array:
    there = np.ones(count, np.bool_)
    for optional, mask in masks.items():
        if f"{path}.".startswith(f"{optional}."):
            there = there & mask
    return there


def _names(table: Table) -> Iterator[str]:
    """Every possible name of an array of this table."""
    for path, column in table.data.items():
        if column.role != "constraint_index":
            yield full_path(table, path)
        if column.role == "param":
            yield from (f"{full_path(table, path)}.{part}" for part in ("fixed", *ENDS))
    for path in table.optionals:
        if path not in table.data or table.data[path].role != "ref":
            yield full_path(table, presence_name(table, path))
    if table.layout.parent:
        yield offsets_name(table)
    if table.layout.path:
        yield f"{table.layout.path}.count"
