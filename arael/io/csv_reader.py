"""CSV reader: the rows of one collection, one scalar per column (LANGUAGE section 10).

The first line names the columns: ``x``, ``pos.x`` or ``pos[0]``, ``m[0][1]``, ``q.w``,
``info.tilt_roll``, ``pos.fixed`` or ``pos.x.fixed``, ``pos.x.low``; refs are indices or keys. An
empty cell is an absent optional, or the default; of a bound the model's.
"""

from __future__ import annotations

import csv
import io
import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import AraelError
from arael.io.columns import scalar_names
from arael.io.plain_numbers import real, whole
from arael.io.refs import PendingRefs
from arael.io.report import Report
from arael.runtime.layout import Column
from arael.runtime.store import Store, Table
from arael.runtime.store.bounds import (
    COMPONENTS_FIXED,
    ENDS,
    OPEN,
    empty,
    first_empty,
    has_components,
    split_fixed,
)
from arael.runtime.store.messages import SCALAR_WORDS, error, shorten, suggestion
from arael.runtime.store.slots import Ints
from arael.runtime.store.values import convert

Array = NDArray[Any]
TRUTH = {"true": True, "false": False, "1": True, "0": False}


def read(store: Store, content: bytes, name: str, collection: str | None) -> None:
    """Replace the rows of one collection by those of a CSV text.

    Raises
    ------
    AraelError
        With file, line and column, several at once: E0713 no such collection, E0711 not CSV, E0701
        unknown column, E0702 missing, E0703 wrong type, E0704 wrong number of cells, E0705 not
        finite, E0706 does not fit, E0708 ref out of range, E0718 a column twice. The store is then
        unchanged.
    """
    table = choose(store, name, collection)
    report = Report(name)
    header, rows, lines = csv_rows(content, name)
    reader = _Reader(table, header, rows, lines, report)
    report.run(reader.convert)
    kept = [(t, t.snapshot()) for t in table.with_descendants()]
    try:
        report.run(reader.put)
    except AraelError:
        for changed, state in kept:
            changed.restore(state)
        raise


def choose(store: Store, name: str, collection: str | None) -> Table:
    """Return the table of a CSV file: given, with the name of the file, or the only one."""
    tables = {
        t.layout.path: t for t in store.tables.values() if t.layout.path and not t.layout.parent
    }
    stem = os.path.basename(name).removesuffix(".gz")
    wanted = collection or os.path.splitext(stem)[0]
    if wanted in tables:
        return tables[wanted]
    if collection is None and len(tables) == 1:
        return next(iter(tables.values()))
    what = f"the model has no collection `{shorten(wanted)}`"
    if collection is None:
        what = "which collection is this? the file holds one"
    raise error("E0713", what, name, help=suggestion(wanted, list(tables)) if tables else "")


def csv_rows(
    content: bytes, name: str, delimiter: str | None = None
) -> tuple[list[str], list[list[str]], list[int]]:
    """Return header, rows and the line of each row.

    Parameters
    ----------
    delimiter : between cells; None: the first of comma, tab and semicolon that the header has
    """
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as failure:
        line = content.count(b"\n", 0, failure.start) + 1
        raise error("E0711", "not UTF-8 text", f"{name}:{line}") from None
    if delimiter is None:
        first = text.lstrip("\r\n").split("\n", 1)[0]
        delimiter = next((d for d in ",\t;" if d in first), ",")
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=delimiter, strict=True)
    rows, lines = [], []
    try:
        for row in reader:
            if row:
                rows.append(row)
                lines.append(reader.line_num)
    except csv.Error as failure:
        raise error("E0711", f"not CSV: {failure}", f"{name}:{reader.line_num}") from None
    if not rows:
        raise error("E0712", "the file is empty", name)
    header = [cell.strip() for cell in rows[0]]
    return header, rows[1:], lines[1:]


class _Reader:
    def __init__(
        self,
        table: Table,
        header: list[str],
        rows: list[list[str]],
        lines: list[int],
        report: Report,
    ) -> None:
        self.table = table
        self.header = header
        self.rows = rows
        self.lines = lines
        self.report = report
        self.columns: dict[str, Array] = {}
        self.refs: list[tuple[Column, list[Any], Ints, Any]] = []

    def _at(self, row: int, name: str) -> str:
        return f"{self.report.name}:{self.lines[row]}: {name}"

    def _add(
        self, code: str, message: str, row: int, name: str, column: Column | None = None
    ) -> None:
        self.report.take(error(code, message, self._at(row, name), column).diagnostics[0])

    # --- conversion ----------------------------------------------------------------------------

    def convert(self) -> None:
        """Convert all cells to arrays, without changing the table."""
        cells = self._cells()
        if cells is None:
            return
        table = self.table
        known: set[str] = set()
        for column in table.data.values():
            if column.role == "constraint_index":
                continue
            names = _given_names(column, cells)
            known.update(names or _all_names(column))
            if column.role == "param":
                known.update(_own_names(column))
                self._fixed(column, cells)
                self._bounds(column, cells)
            if names is None:
                self._lacking(column, cells)
            else:
                self._column(column, [cells[n] for n in names], names)
        extra = [n for n in cells if n not in known]
        if extra:
            every = [n for c in table.data.values() for n, _ in scalar_names(c)]
            for name in extra:
                self.report.add(
                    "E0701",
                    f"`{table.layout.struct}` has no column `{shorten(name)}`",
                    "",
                    help=suggestion(name, every),
                )

    def _cells(self) -> dict[str, tuple[str, ...]] | None:
        """Cells by column; None if some row has not the length of the header."""
        header = self.header
        for name in sorted({n for n in header if header.count(n) > 1}):
            self.report.add("E0718", f"the column `{shorten(name)}` is given twice", "")
        if not set(map(len, self.rows)) <= {len(header)}:
            for i, row in enumerate(self.rows):
                if len(row) != len(header):
                    self._add("E0704", f"expected {len(header)} cells, found {len(row)}", i, "row")
            return None
        columns = zip(*self.rows, strict=True) if self.rows else ((),) * len(header)
        return dict(zip(header, columns, strict=True))

    def _lacking(self, column: Column, cells: dict[str, tuple[str, ...]]) -> None:
        """Accept a missing column if it has a default or is optional, or report it."""
        path = column.path
        some = [n for n, _ in scalar_names(column) if n in cells]
        around = [o for o in self.table.optionals if f"{path}.".startswith(f"{o}.")]
        starts = tuple(f"{o}." for o in around)
        if not some and (column.default is not None or path in self.table.optionals):
            return
        if not some and around and not any(n.startswith(starts) for n in cells):
            return
        lacking = next(n for n, _ in scalar_names(column) if n not in cells)
        self.report.add("E0702", f"the column `{lacking}` is missing", "", column)

    def _fixed(self, column: Column, cells: dict[str, tuple[str, ...]]) -> None:
        """Flags of a parameter, and of its components."""
        whole = self._flags(f"{column.path}.fixed", cells)
        if whole is not None:
            self.columns[f"{column.path}.fixed"] = whole
        for names in _namings(column) if has_components(column) else ():
            parts = [self._flags(f"{name}.fixed", cells) for name in names]
            if all(part is None for part in parts):
                continue
            none = np.zeros(len(self.rows), np.bool_)
            some = np.stack([none if part is None else part for part in parts], axis=-1)
            every, some = split_fixed(some)
            self.columns[f"{column.path}.fixed"] = every if whole is None else every | whole
            self.columns[f"{column.path}.{COMPONENTS_FIXED}"] = some
            return

    def _flags(self, name: str, cells: dict[str, tuple[str, ...]]) -> Array | None:
        if name not in cells:
            return None
        flags = self._parse("bool", cells[name], np.arange(len(self.rows)), name, None)
        return None if flags is None else np.array(flags, np.bool_)

    def _bounds(self, column: Column, cells: dict[str, tuple[str, ...]]) -> None:
        """Bounds of a parameter; an empty cell is that of the model, `inf` none."""
        lettered, numbered = _namings(column)
        found: dict[str, Array] = {}
        for end in ENDS:
            names = numbered if any(f"{n}.{end}" in cells for n in numbered) else lettered
            if not any(f"{n}.{end}" in cells for n in names):
                continue
            bounds = self.table.blank_own(column, end, len(self.rows))
            flat = bounds.reshape(len(self.rows), len(names))
            for k, name in enumerate(names):
                title = f"{name}.{end}"
                for i, cell in enumerate(cells.get(title, ())):
                    if cell.strip():
                        flat[i, k] = self._bound(cell, end, i, title, column)
            if not self._may_have(column, end, names):
                return
            self.columns[f"{column.path}.{end}"] = found[end] = bounds
        if not found or self.report.found:
            return
        low, high = (
            found.get(end, self.table.blank_own(column, end, len(self.rows))) for end in ENDS
        )
        row = first_empty(low, high)
        if row is not None:
            self.report.take(empty(self._at(row, column.path), column, low[row], high[row]))

    def _may_have(self, column: Column, end: str, names: list[str]) -> bool:
        """Whether a parameter takes bounds; reports it if not."""
        try:
            self.table.checked_bounds(
                column.path, end, None, None, self.report.at(f"{names[0]}.{end}")
            )
        except AraelError as failure:
            self.report.take(failure.diagnostics[0])
            return False
        return True

    def _bound(self, cell: str, end: str, row: int, title: str, column: Column) -> float:
        """One bound; `inf` and `-inf` are open ends."""
        text = cell.strip().lower()
        if text.lstrip("+-") in ("inf", "infinity"):
            return -np.inf if text.startswith("-") else np.inf
        try:
            found = real(text)
            if not np.isnan(found):
                return found
        except ValueError:
            pass
        self._add("E0703", f'expected a number or inf, found "{shorten(cell)}"', row, title)
        return float(OPEN[end])

    def _column(self, column: Column, parts: list[tuple[str, ...]], names: list[str]) -> None:
        """Convert the cells of one field, all of its scalars."""
        table, count, path = self.table, len(self.rows), column.path
        empty = np.array([[not c.strip() for c in part] for part in parts], np.bool_)
        empty = empty.reshape(len(parts), count)
        there: NDArray[np.bool_] = np.asarray(~empty.all(axis=0))
        if column.kind == "string" and path not in table.optionals:
            there[:] = True
        absent_ok = column.default is not None or any(
            f"{path}.".startswith(f"{o}.") for o in table.optionals
        )
        for i in np.flatnonzero(empty.any(axis=0) & (there | (not absent_ok))).tolist():
            if column.kind != "string":
                self._add(
                    "E0702", "the cell is empty", i, names[int(np.argmax(empty[:, i]))], column
                )
        if self.report.found:
            return
        for optional in table.optionals:
            if f"{path}.".startswith(f"{optional}."):
                mask = self.columns.setdefault(f"{optional}?", np.zeros(count, np.bool_))
                mask |= there
        rows = np.flatnonzero(there)
        kind = "ref" if column.role == "ref" else column.kind
        values = []
        for part, name in zip(parts, names, strict=True):
            parsed = self._parse(kind, [part[i] for i in rows.tolist()], rows, name, column)
            if parsed is None:
                return
            values.append(parsed)
        if column.role == "ref":
            self.refs.append((column, values[0], rows, lambda i: f"row {rows[i]}: {path}"))
            return
        array = np.array(values, dtype=object if column.kind == "string" else None)
        array = (
            array.T.reshape(len(rows), *column.shape)
            if len(rows)
            else array.reshape(0, *column.shape)
        )
        full = table.blank_column(path, count)
        try:
            full[there] = convert(
                column, array, len(rows), table.real, lambda i: self._at(int(rows[i]), path), True
            )
        except AraelError as failure:
            for diagnostic in failure.diagnostics:
                self.report.take(diagnostic)
        self.columns[path] = full

    def _parse(
        self, kind: str, cells: Any, rows: Ints, name: str, column: Column | None
    ) -> list[Any] | None:
        """Cells as values; None after reporting invalid ones."""
        if kind == "string":
            return list(cells)
        try:
            return [_value(kind, cell) for cell in cells]
        except ValueError:
            pass
        words = {**SCALAR_WORDS, "ref": "an index"}[kind]
        for row, cell in zip(rows.tolist(), cells, strict=True):
            try:
                _value(kind, cell)
            except ValueError:
                self._add("E0703", f'expected {words}, found "{shorten(cell)}"', row, name, column)
        return None

    # --- into the table --------------------------------------------------------------------------

    def put(self) -> None:
        """Replace the rows of the table, then set the refs."""
        self._check_structs()
        if self.report.found:
            return
        table, count = self.table, len(self.rows)
        table.clear()
        table.extend_trusted(count, None, self.columns)
        refs = PendingRefs(table.store, self.report)
        refs.take(table, self.refs, lambda i: self._at(i, ""))
        refs.resolve()
        for column, _, rows, _ in self.refs:
            if column.path in table.optionals:
                table.column(f"{column.path}?")[rows] = True

    def _check_structs(self) -> None:
        """Report optional structs that are only partially given."""
        table = self.table
        for optional in table.optionals:
            mask = self.columns.get(f"{optional}?")
            if mask is None or optional in table.data:
                continue
            for path, column in table.data.items():
                if not path.startswith(f"{optional}.") or column.default is not None:
                    continue
                deeper = [
                    o for o in table.optionals if f"{path}.".startswith(f"{o}.") and o != optional
                ]
                if deeper or path not in self.columns:
                    continue
                given = self._given(path)
                for i in np.flatnonzero(mask & ~given).tolist():
                    self._add("E0702", "the cell is empty", i, path, column)

    def _given(self, path: str) -> NDArray[np.bool_]:
        column = self.table.data[path]
        names = next(n for n, _ in scalar_names(column) if n in self.header)
        index = self.header.index(names)
        return np.array([bool(row[index].strip()) for row in self.rows], np.bool_)


def _own_names(column: Column) -> set[str]:
    """Names of the flags and bounds of a parameter."""
    found = {f"{column.path}.fixed"}
    for names in _namings(column):
        for name in names:
            found.update(f"{name}.{end}" for end in ENDS)
            if has_components(column):
                found.add(f"{name}.fixed")
    return found


def _all_names(column: Column) -> set[str]:
    lettered, numbered = _namings(column)
    return {*lettered, *numbered}


def _namings(column: Column) -> tuple[list[str], list[str]]:
    """Return the names of a field's scalars with letters and with indices."""
    scalars = list(scalar_names(column))
    numbers = [column.path + "".join(f"[{k}]" for k in index) for _, index in scalars]
    return [name for name, _ in scalars], numbers


def _given_names(column: Column, cells: dict[str, tuple[str, ...]]) -> list[str] | None:
    """The given names of all scalars of a field, with letters or with indices."""
    for names in _namings(column):
        if all(n in cells for n in names):
            return names
    return None


def _value(kind: str, cell: str) -> Any:
    text = cell.strip()
    if kind == "bool":
        if text.lower() not in TRUTH:
            raise ValueError(text)
        return TRUTH[text.lower()]
    if kind == "ref":
        return int(text) if text.lstrip("-").isdecimal() and text.isascii() else cell
    return whole(text) if kind == "int" else real(text)
