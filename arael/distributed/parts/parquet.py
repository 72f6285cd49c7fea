"""A folder of Parquet files, of which each part reads its rows only.

The rows of a collection are in ``poses/*.parquet``, in the order of the names of the files, or in
``poses.parquet``; fields of the root are the one row of ``root.parquet``. Columns are those of
`arael.io.arrow`: one for each scalar. Rows of a nested collection (``points.seen/*.parquet``) have
the row of their owner in the whole data set as ``parent``, and are sorted by it. Pieces have the
interface of NPZ archives (`data.Archive`): arrays by the names of `arael.io.npz`.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.io.columns import scalar_names
from arael.io.packages import required
from arael.runtime.layout import Column, Layout, Table
from arael.runtime.store.bounds import ENDS, has_components, of_model
from arael.runtime.store.messages import error, shorten, suggestion

Array = NDArray[Any]
Ints = NDArray[np.int64]

PARENT = "parent"
ROOT = "root"
ENDING = ".parquet"


def has_parquet(folder: Path) -> bool:
    """Whether a folder, or one in it, has Parquet files."""
    return next(folder.glob(f"*{ENDING}"), next(folder.glob(f"*/*{ENDING}"), None)) is not None


def pieces_of(folder: Path, layout: Layout) -> list[Piece]:
    """The files of a folder with the collections that they are of, in the order of their rows.

    Raises
    ------
    AraelError
        E0725 without pyarrow; E0713 no such collection; E0711 no Parquet file, or a damaged one.
    """
    tables = {table.path or ROOT: table for table in layout.tables}
    files = [(file.name.removesuffix(ENDING), file) for file in sorted(folder.glob(f"*{ENDING}"))]
    files += [(file.parent.name, file) for file in sorted(folder.glob(f"*/*{ENDING}"))]
    found = []
    for name, file in files:
        if name not in tables:
            known = sorted(tables)
            help_ = f"{suggestion(name, known)}; name files {known[0]}/*{ENDING}"
            what = f"the model has no collection `{shorten(name)}`"
            raise error("E0713", what, str(file), help=help_)
        found.append(Piece(file, tables[name]))
    return found


class Piece:
    """Some rows of one table: the columns of a file as arrays that are read when asked for.

    Attributes
    ----------
    path, table : of the file
    """

    def __init__(self, path: Path, table: Table) -> None:
        self.path, self.table = str(path), table
        self._arrow = required("pyarrow", self.path, "Parquet")
        pq = required("pyarrow.parquet", self.path, "Parquet")
        try:
            with pq.ParquetFile(self.path) as file:
                self._titles: list[str] = list(file.schema_arrow.names)
                groups = range(file.metadata.num_row_groups)
                sizes = [file.metadata.row_group(k).num_rows for k in groups]
        except (self._arrow.ArrowException, OSError, ValueError):
            raise error("E0711", "not a Parquet file, or a damaged one", self.path) from None
        for title in {t for t in self._titles if self._titles.count(t) > 1}:
            raise error("E0718", f"the column `{shorten(title)}` is given twice", self.path)
        self.begins: Ints = np.concatenate(([0], np.cumsum(sizes))).astype(np.int64)
        if not table.path and self.count != 1:
            message = f"the root has one row, found {self.count}"
            raise error("E0704", message, self.path)

    @property
    def count(self) -> int:
        """Number of rows."""
        return int(self.begins[-1])

    def __iter__(self) -> Iterator[str]:
        return iter(self._arrays)

    def __contains__(self, name: object) -> bool:
        return name in self._arrays or name == f"{self.table.path}.count"

    def __getitem__(self, name: str) -> Array:
        return np.array(self.count) if name not in self._arrays else self.rows(name, None)

    def length(self, name: str) -> int:
        """Rows of an array."""
        return self.count

    @cached_property
    def _arrays(self) -> dict[str, tuple[str, Column | None]]:
        """Name of each array -> what is asked for, and the field that it is of."""
        prefix = f"{self.table.path}." if self.table.path else ""
        titles = set(self._titles)
        found: dict[str, tuple[str, Column | None]] = {}
        columns = [c for c in self.table.columns if c.role not in ("present", "constraint_index")]
        for column in columns:
            scalars = _scalars(column)
            name = prefix + column.path
            if titles & set(scalars):
                found[name] = ("value", column)
            titles -= set(scalars)
            if column.role != "param":
                continue
            flags = [f"{column.path}.fixed"]
            flags += [f"{s}.fixed" for s in scalars] if has_components(column) else []
            for what, some in [
                ("fixed", flags),
                *((end, [f"{s}.{end}" for s in scalars]) for end in ENDS),
            ]:
                if titles & set(some):
                    found[f"{name}.{what}"] = (what, column)
                titles -= set(some)
        paths = {c.path: c.role for c in columns}
        for column in self.table.columns:
            path = column.path
            if column.role != "present" or paths.get(path) == "ref":
                continue
            if any(f"{p}.".startswith(f"{path}.") and prefix + p in found for p in paths):
                name = f"{path}.present" if path in paths else path
                found[prefix + name] = ("present", column)
        if self.table.parent and PARENT not in paths:
            titles.discard(PARENT)
        # What is left is refused where the rows are adopted.
        return {**found, **{prefix + title: (title, None) for title in sorted(titles)}}

    def parents(self) -> Ints:
        """(rows,) owner of each row, in the whole data set.

        Raises
        ------
        AraelError
            E0702 no such column; E0704 not ascending integers.
        """
        if PARENT not in self._titles:
            message = f"the rows of a nested collection need their owners as `{PARENT}`"
            raise error("E0702", message, self.path)
        values, gaps = self._cells([PARENT], None)[PARENT]
        if values.dtype.kind not in "iu" or gaps.any() or (np.diff(values) < 0).any():
            message = f"`{PARENT}` must be row numbers of the owners, sorted"
            raise error("E0704", message, self.path)
        return values.astype(np.int64)

    def rows(self, name: str, rows: Ints | None) -> Array:
        """Some rows, ascending, of an array; None: all.

        Raises
        ------
        AraelError
            E0702 a scalar of the field is missing, or a value; E0703 a column of another type.
        """
        what, column = self._arrays[name]
        if column is None:
            return self._cells([what], rows)[what][0]
        if what == "present":
            return self._presence(column.path, rows)
        scalars = _scalars(column)
        if what == "fixed":
            return self._fixed(column, scalars, rows)
        titles = [s if what == "value" else f"{s}.{what}" for s in scalars]
        there = [title for title in titles if title in self._titles]
        if what == "value" and len(there) < len(titles):
            lacking = next(title for title in titles if title not in there)
            raise error("E0702", f"the column `{lacking}` is missing", self.path, column)
        cells = self._cells(there, rows)
        found = np.zeros((0, 0))
        if what != "value":
            count = self.count if rows is None else len(rows)
            found = np.array(np.broadcast_to(of_model(column, what), (count, *column.shape)))
            flat = found.reshape(count, -1)
            for k, title in enumerate(titles):
                if title in cells:
                    values, gaps = cells[title]
                    flat[~gaps, k] = values[~gaps]
            return found
        self._refuse_gaps(column, cells, rows)
        if column.role == "ref":
            values, gaps = cells[column.path]
            return np.where(gaps, -1, values)
        if not column.shape:
            return cells[titles[0]][0]
        stacked = np.stack([cells[title][0] for title in titles], axis=-1)
        return stacked.reshape(-1, *column.shape)

    def _refuse_gaps(
        self, column: Column, cells: dict[str, tuple[Array, NDArray[np.bool_]]], rows: Ints | None
    ) -> None:
        if column.role == "ref" or self._optionals(column):
            return
        for title, (_, gaps) in cells.items():
            if gaps.any():
                row = int(np.argmax(gaps))
                row = row if rows is None else int(rows[row])
                raise error("E0702", f"`{title}` has no value in row {row}", self.path, column)

    def _optionals(self, column: Column) -> list[str]:
        """The optional fields that a field is in, or is itself."""
        known = [c.path for c in self.table.columns if c.role == "present"]
        return [path for path in known if f"{column.path}.".startswith(f"{path}.")]

    def _presence(self, path: str, rows: Ints | None) -> Array:
        """Where any field of an optional has all its scalars."""
        found = np.zeros(self.count if rows is None else len(rows), dtype=np.bool_)
        for column in self.table.columns:
            titles = _scalars(column)
            inside = f"{column.path}.".startswith(f"{path}.")
            if inside and column.role != "present" and set(titles) <= set(self._titles):
                cells = self._cells(titles, rows)
                found |= ~np.logical_or.reduce([gaps for _, gaps in cells.values()])
        return found

    def _fixed(self, column: Column, scalars: list[str], rows: Ints | None) -> Array:
        """Flags of a parameter, (rows,), or of its components, (rows, k)."""
        whole = f"{column.path}.fixed"
        own = [f"{s}.fixed" for s in scalars] if column.shape else []
        cells = self._cells([t for t in (whole, *own) if t in self._titles], rows)
        flags = {title: values & ~gaps for title, (values, gaps) in cells.items()}
        if not any(title in flags for title in own):
            return flags[whole]
        none = np.zeros(self.count if rows is None else len(rows), dtype=np.bool_)
        every = flags.get(whole, none)
        return np.stack([every | flags.get(title, none) for title in own], axis=-1)

    def _cells(
        self, titles: list[str], rows: Ints | None
    ) -> dict[str, tuple[Array, NDArray[np.bool_]]]:
        """Values of columns, and where they are missing; only row groups with such rows are read.

        Of rows only those asked for are kept of each group, so that no more than one group is in
        memory beside them.
        """
        pq = required("pyarrow.parquet", self.path, "Parquet")
        every: dict[str, list[Any]] = {title: [] for title in titles}
        try:
            with pq.ParquetFile(self.path) as file:
                for k, (begin, end) in enumerate(
                    zip(self.begins[:-1].tolist(), self.begins[1:].tolist(), strict=True)
                ):
                    inside = None
                    if rows is not None:
                        first, last = np.searchsorted(rows, (begin, end))
                        inside = rows[first:last] - begin
                        if not len(inside):
                            continue
                    group = file.read_row_group(k, columns=titles)
                    group.validate(full=True)
                    for title in titles:
                        cells = self._plain(title, group.column(title))
                        values, gaps = self._values(cells)
                        every[title].append(
                            (values, gaps) if inside is None else (values[inside], gaps[inside])
                        )
                empty = file.schema_arrow.empty_table()
        except (self._arrow.ArrowException, OSError, ValueError):
            raise error("E0711", "not a Parquet file, or a damaged one", self.path) from None
        found = {}
        for title, pieces in every.items():
            known = pieces or [self._values(self._plain(title, empty.column(title)))]
            found[title] = (
                np.concatenate([values for values, _ in known]),
                np.concatenate([gaps for _, gaps in known]),
            )
        return found

    def _plain(self, title: str, cells: Any) -> Any:
        """Cells without a dictionary, if they are of a type that is read."""
        types = self._arrow.types
        if types.is_dictionary(cells.type):
            cells = cells.cast(cells.type.value_type)
        kind = cells.type
        tests = (types.is_boolean, types.is_integer, types.is_floating)
        texts = (types.is_string, types.is_large_string)
        if any(test(kind) for test in (*tests, *texts)):
            return cells
        message = f"expected numbers, bools or strings, found {shorten(str(kind))}"
        raise error("E0703", message, f"{self.path}: {shorten(title)}")

    def _values(self, cells: Any) -> tuple[Array, NDArray[np.bool_]]:
        gaps = np.asarray(cells.is_null())
        types, kind = self._arrow.types, cells.type
        blank: Any = 0
        if types.is_boolean(kind):
            blank = False
        elif types.is_string(kind) or types.is_large_string(kind):
            blank = ""
        elif types.is_floating(kind):
            blank = 0.0
        values = np.asarray(cells.fill_null(blank) if gaps.any() else cells)
        if values.dtype == object:
            values = values.astype(np.str_)
        return values, gaps


def _scalars(column: Column) -> list[str]:
    """Titles of a field's columns."""
    if column.role == "ref":
        return [column.path]
    return [name for name, _ in scalar_names(column)]
