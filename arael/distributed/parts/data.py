"""Columns of a data set of which each part reads its rows only.

A data set is an NPZ file, or a folder of NPZ files whose rows follow each other in the order of
their names: refs count the rows of the whole data set, offsets those of their file. Fields of the
root are those of the first file that has them. Or it is a folder of Parquet files (`parquet.py`).
Other formats are read whole, and cut then.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import AraelError, Diagnostic
from arael.distributed.parts.parquet import Piece, has_parquet, pieces_of
from arael.distributed.parts.shares import Share
from arael.io import npz
from arael.io.columns import full_path, offsets_name, presence_name
from arael.runtime.layout import Layout
from arael.runtime.store import Store

Array = NDArray[Any]
Ints = NDArray[np.int64]

_BOUNDS = {"low": -np.inf, "high": np.inf}


@dataclass
class Columns:
    """Arrays by name, as `arael.io.npz` names them, in one piece or in several.

    Attributes
    ----------
    pieces : each a mapping from names to arrays; that of a file reads an array when asked for it
    label : for messages
    """

    pieces: list[Any]
    label: str
    _counts: dict[str, list[int]] = field(default_factory=dict)

    def names(self) -> list[str]:
        """All names, each once."""
        return list(dict.fromkeys(name for piece in self.pieces for name in piece))

    def counts(self, layout: Layout, path: str) -> list[int]:
        """Rows of a table in each piece."""
        if path not in self._counts:
            self._counts[path] = [_rows(layout, piece, path) for piece in self.pieces]
        return self._counts[path]

    def take(self, layout: Layout, path: str, name: str, rows: Ints | None = None) -> Array:
        """Some rows, ascending, of a column of a table; None: all.

        Raises
        ------
        AraelError
            E0702 a piece lacks a column that others have.
        """
        if not path:
            return np.asarray(next(piece[name] for piece in self.pieces if name in piece))
        ends = np.concatenate(([0], np.cumsum(self.counts(layout, path))))
        found = []
        for piece, begin, end in zip(self.pieces, ends[:-1], ends[1:], strict=True):
            inside = None
            if rows is not None:
                first, last = np.searchsorted(rows, (begin, end))
                inside = rows[first:last] - begin
                if not len(inside):
                    continue
            elif begin == end:
                continue
            if name not in piece:
                count = int(end - begin) if inside is None else len(inside)
                found.append(self._absent(name, count))
            elif isinstance(piece, Piece):
                found.append(piece.rows(name, inside))
            else:
                array = np.asarray(piece[name])
                found.append(array if inside is None else array[inside])
        if not found:
            some = next(np.asarray(piece[name]) for piece in self.pieces if name in piece)
            return some[:0]
        return found[0] if len(found) == 1 else np.concatenate(found)

    def _absent(self, name: str, count: int) -> Array:
        like = next(np.asarray(piece[name]) for piece in self.pieces if name in piece)
        last = name.rpartition(".")[2]
        if last in _BOUNDS:
            return np.full((count, *like.shape[1:]), _BOUNDS[last])
        if like.dtype == np.bool_:
            return np.zeros((count, *like.shape[1:]), dtype=np.bool_)
        raise AraelError(
            Diagnostic(
                "E0702",
                f"`{name}` is missing in some files of the data set",
                origin=self.label,
                help=("give the column in every file, or in none",),
            )
        )

    def offsets(self, layout: Layout, path: str) -> Ints:
        """(owners + 1,) row offsets of a nested table by owner, of the whole data set."""
        owners_count = sum(self.counts(layout, layout.table(path).parent))
        owned = [p for p in self.pieces if isinstance(p, Piece) and p.table.path == path]
        if owned:
            return _offsets_by_parents([p.parents() for p in owned], owners_count, owned[-1].path)
        found = [np.zeros(1, dtype=np.int64)]
        total = 0
        name = f"{path}.offsets"
        owners = self.counts(layout, layout.table(path).parent)
        for piece, count in zip(self.pieces, owners, strict=True):
            own = np.asarray(piece[name]) if name in piece else np.zeros(count + 1, dtype=np.int64)
            found.append(own[1:].astype(np.int64) + total)
            total += int(own[-1]) if len(own) else 0
        return np.concatenate(found)


def _offsets_by_parents(parents: list[Ints], owners: int, label: str) -> Ints:
    """(owners + 1,) row offsets by owner from the owner of each row."""
    every = np.concatenate(parents)
    if (np.diff(every) < 0).any() or (len(every) and not 0 <= every[0] <= every[-1] < owners):
        raise AraelError(
            Diagnostic(
                "E0704",
                f"`parent` must be row numbers of the {owners} owners, sorted over all files",
                origin=label,
                help=("sort the rows by their owners before they are written",),
            )
        )
    return np.searchsorted(every, np.arange(owners + 1)).astype(np.int64)


def _rows(layout: Layout, piece: Any, path: str) -> int:
    table = layout.table(path)
    if isinstance(piece, Piece):
        return piece.count if piece.table.path == path else 0
    if f"{path}.count" in piece:
        return int(np.asarray(piece[f"{path}.count"]))
    if table.parent:
        own = np.asarray(piece[f"{path}.offsets"]) if f"{path}.offsets" in piece else np.zeros(1)
        return int(own[-1])
    for name in [f"{path}.{c.path}" for c in table.columns] + [
        f"{path}.{v.path}" for v in table.values
    ]:
        if name in piece:
            return _length(piece, name)
    return 0


def _length(piece: Any, name: str) -> int:
    if isinstance(piece, Archive):
        return piece.length(name)
    return len(piece[name])


class Archive:
    """An NPZ file whose arrays are read when they are asked for."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = os.fspath(path)
        try:
            with np.load(self.path, allow_pickle=False) as archive:
                self._names = list(archive.files)
        except (*npz.DAMAGED, AttributeError):
            raise AraelError(
                Diagnostic(
                    "E0711",
                    "not a NumPy archive, or a damaged one",
                    origin=self.path,
                    help=("a folder of data holds .npz files, as `arael convert` writes them",),
                )
            ) from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._names)

    def __contains__(self, name: object) -> bool:
        return name in self._names

    def __getitem__(self, name: str) -> Array:
        with np.load(self.path, allow_pickle=False) as archive:
            return np.asarray(archive[name])

    def length(self, name: str) -> int:
        """Rows of an array, by its header."""
        # imported here: start-up time
        import zipfile

        with zipfile.ZipFile(self.path) as archive, archive.open(f"{name}.npy") as file:
            version = np.lib.format.read_magic(file)
            read = (
                np.lib.format.read_array_header_1_0
                if version == (1, 0)
                else np.lib.format.read_array_header_2_0
            )
            shape = read(file)[0]
        return int(shape[0]) if shape else 1


def is_columnar(path: str | os.PathLike[str]) -> bool:
    """Whether parts can read their rows of a data set without reading all of it."""
    return os.path.isdir(path) or os.fspath(path).endswith(".npz")


def columns_of(path: str | os.PathLike[str], layout: Layout) -> Columns:
    """The columns of an NPZ file, or of a folder of such or of Parquet files.

    Raises
    ------
    AraelError
        E0711 not an archive, or a folder without files; of Parquet files also E0713 no such
        collection and E0725 without pyarrow.
    """
    where = Path(path)
    if not where.is_dir():
        return Columns([Archive(where)], os.fspath(path))
    files = sorted(where.glob("*.npz"))
    if not files:
        if has_parquet(where):
            return Columns(list(pieces_of(where, layout)), os.fspath(path))
        raise AraelError(
            Diagnostic(
                "E0711",
                "the folder holds neither .npz nor .parquet files",
                origin=os.fspath(path),
                help=("a data set in parts is a folder of such files, each with some of the rows",),
            )
        )
    return Columns([Archive(file) for file in files], os.fspath(path))


def whole_skeleton(layout: Layout, slim: Layout, columns: Columns) -> Store:
    """The store of the model `slim` (see `shares.skeleton`) with all rows of a data set."""
    store = Store(slim)
    arrays: dict[str, Array] = {}
    names = set(columns.names())
    for path, table in store.tables.items():
        wanted = [f"{path}.count"] if path and not table.layout.parent else []
        for column in table.data.values():
            name = full_path(table, column.path)
            wanted += [name]
            if column.role == "param":
                wanted += [f"{name}.{extra}" for extra in ("fixed", *_BOUNDS)]
        wanted += [full_path(table, held.path) for held in table.layout.values]
        for name in wanted:
            if name.endswith(".count") and path:
                arrays[name] = np.array(sum(columns.counts(layout, path)))
            elif name in names:
                arrays[name] = columns.take(layout, path, name)
        values = {c.path for c in layout.table(path).columns if c.role != "present"}
        for optional in table.optionals:
            name = full_path(table, f"{optional}.present" if optional in values else optional)
            if name in names and not (
                optional in table.data and table.data[optional].role == "ref"
            ):
                # Here an optional value is as an optional struct, since its numbers are left out.
                given = columns.take(layout, path, name)
                arrays[full_path(table, presence_name(table, optional))] = given
        if table.layout.parent:
            arrays[offsets_name(table)] = columns.offsets(layout, path)
    npz.adopt(store, arrays, columns.label)
    return store


def rows_of_share(layout: Layout, columns: Columns, share: Share) -> dict[str, Array]:
    """The arrays of one part, as those of a data set of its own."""
    # The longest path first, so that `a.b.c` is of the table `a.b`, if there is one.
    tables = sorted((t.path for t in layout.tables if t.path), key=len, reverse=True)
    arrays: dict[str, Array] = {}
    lists = {
        f"{t.path}.{held.path}" if t.path else held.path
        for t in layout.tables
        for held in t.values
        if held.refs
    }
    refs = {(f"{path}.{c}" if path else c) for path, c in share.refs}
    for name in columns.names():
        if name in refs or name in lists:
            continue
        path = next((p for p in tables if name.startswith(f"{p}.")), "")
        rest = name.removeprefix(f"{path}.")
        if path and rest in ("offsets", "count"):
            continue
        rows = share.rows[path] if path else None
        arrays[name] = columns.take(layout, path, name, rows)
    for (path, column), index in share.refs.items():
        arrays[f"{path}.{column}" if path else column] = index if path else index.reshape(1)
    for path, owners in share.owners.items():
        parents = len(share.rows[layout.table(path).parent])
        counts = np.bincount(owners, minlength=parents)
        arrays[f"{path}.offsets"] = np.concatenate(([0], np.cumsum(counts))).astype(np.int64)
    for path in tables:
        if not layout.table(path).parent:
            arrays[f"{path}.count"] = np.array(len(share.rows[path]))
    return arrays
