"""Python interface of a collection: rows by index, columns as arrays."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.arguments import wrong_argument
from arael.diagnostics.frames import public, user_frames
from arael.diagnostics.records import AraelError
from arael.display.displayed import Displayed
from arael.display.sheet import Sheet
from arael.face import given
from arael.face.fields import Fields
from arael.face.ref import Ref, Refs
from arael.runtime.layout import Column
from arael.runtime.store import Handles, Table
from arael.runtime.store.columns import Rows
from arael.runtime.store.messages import Name, error
from arael.runtime.store.schema import Nested

if TYPE_CHECKING:
    import pandas
    import xarray

Ints = NDArray[np.int64]


class Collection(Displayed, Fields):
    """All rows of a table, those nested in one row, or a selection of them.

    ``poses.pos.value`` is the column of all rows, ``poses[3]`` a row (`Ref`), ``poses[2:5]`` a
    selection. ``landmarks[5].frines`` are the frines of one landmark, ``landmarks.frines`` those of
    all.
    """

    def __init__(
        self, table: Table, parent: int | None = None, handles: Ints | None = None
    ) -> None:
        # `__setattr__` is for fields.
        own = self.__dict__
        own["_table"], own["_group"] = table, table.fields
        own["_parent"], own["_handles"] = parent, handles

    def _rows(self) -> Rows:
        if self._handles is not None:
            rows = self._table.rows_of(self._handles)
            if len(rows) and rows.min() < 0:
                raise error("E0709", "rows of this choice were removed", self._table.label)
            return _together(rows)
        if self._parent is None:
            return slice(0, self._table.size)
        order, offsets = self._table.grouped()
        owner = self._table.parent.row_of(self._parent)
        return _together(order[offsets[owner] : offsets[owner + 1]])

    def _is_whole(self) -> bool:
        return self._handles is None and self._parent is None

    def _every(self) -> Ints:
        return np.arange(self._table.size)[self._rows()]

    # --- adding ------------------------------------------------------------------------------

    def append(self, /, **values: Any) -> Ref:
        """Add one row at the end.

        Values by field name; a struct held by value as a dict, a collection as a list of dicts, a
        ref as a `Ref`, an index, or the target's text if it declares `key`. A parameter may be
        ``{"value": ..., "fixed": True}``.

        Raises AraelError: E0701 unknown field, E0702 missing, E0703-E0710 wrong values or refs,
        E0718 a key of two rows.
        """
        __tracebackhide__ = True
        with user_frames:
            return self._append(values, front=False)

    def appendleft(self, /, **values: Any) -> Ref:
        """Add one row at the front of a deque; otherwise like `append`."""
        __tracebackhide__ = True
        with user_frames:
            return self._append(values, front=True)

    def _append(self, values: Mapping[str, Any], front: bool) -> Ref:
        table, owner = self._table, self._owner_for_new()
        if not front:
            refs = {
                name: ref._handle
                for name, target in table.plain_rows.refs.items()
                if type(ref := values.get(name)) is Ref and ref._table is target
            }
            plain = table.append_plain(values, refs, owner)
            if plain is not None:
                return Ref(table, plain)
        flat, children = given.flatten(self._group, values, Name(lambda: self._label(owner)))
        handle = table.append(owner, front=front, **flat)
        ref = Ref(table, handle)
        try:
            for nested, items in children:
                collection = Collection(table.store.tables[nested.table.path], parent=handle)
                fill(collection, items, f"{table.row_name(table.row_of(handle))}.{nested.path}")
        except AraelError:
            table.remove(handle)
            raise
        return ref

    def _owner_for_new(self) -> int | None:
        if self._handles is not None:
            raise error("E0424", "a choice of rows cannot grow", self._table.label)
        if self._parent is not None:
            return self._table.parent.row_of(self._parent)
        if self._table.layout.parent:
            raise error(
                "E0424",
                f"which `{self._table.parent.layout.struct}` is the owner of the new row?",
                self._table.label,
                help=f"append to `{self._table.parent.layout.path}[i].{self._table.layout.field}`, "
                "or extend with `parent=`",
            )
        return None

    def _label(self, owner: int | None) -> str:
        if owner is None:
            return f"{self._table.label}[{self._table.size}]"
        return f"{self._table.parent.name_of(owner, self._table.layout.field)}[{len(self)}]"

    @public
    def extend(self, n: Any = None, /, *, parent: Any = None, **values: Any) -> Refs:
        """Add many rows from arrays or a data frame, without Python per row.

        Parameters
        ----------
        n : number of rows, if there is no array; or a data frame of pandas or polars: columns are
            named as in CSV files (``pos.x``, ``att.w``; refs are indices), missing values are
            absent optionals, and a column ``parent`` has the rows of the owners
        parent : for a nested collection the owners of the new rows: `Refs` or dense rows (n,)
        **values : arrays (n, ...) or one value for all, by field name or dotted path; structs also
            as dicts of arrays; the presence of an optional struct as an array or list of bools
            under its name

        Raises
        ------
        AraelError
            As `append`; the collection is then unchanged.
        """
        table = self._table
        if is_frame(n):
            # imported here: start-up time
            from arael.io.frames import columns_of

            frame = n
            n, columns, owners = columns_of(frame, table, self._group)
            parent = owners if parent is None else parent
            values = {**columns, **values}
        flat, children = given.flatten(self._group, values, table.label)
        if children:
            raise error(
                "E0424",
                "a nested collection cannot be given here",
                f"{table.label}.{children[0][0].path}",
                help="extend the nested collection afterwards, with `parent=`",
            )
        owners = self._owners(parent)
        if n is None:
            n = self._count(flat, owners)
        elif not isinstance(n, int | np.integer) or isinstance(n, bool) or n < 0:
            raise wrong_argument(
                table.label, "n", "a number of rows, or a data frame", n, "give arrays by name"
            )
        if owners is not None and owners.shape not in ((), (n,)):
            raise error("E0704", f"expected {n} parents, found {len(owners)}", table.label)
        return Refs(table, table.extend(n, owners, **flat))

    def _owners(self, parent: Any) -> Ints | None:
        if parent is None:
            owner = self._owner_for_new()
            return None if owner is None else np.array(owner)
        if self._parent is not None or not self._table.layout.parent:
            raise error(
                "E0424", "only a nested collection of all rows takes `parent`", self._table.label
            )
        parent = given.refs(parent)
        if not isinstance(parent, Handles):
            return np.asarray(parent, np.int64)
        if parent.table is not self._table.parent:
            raise error("E0710", "the parents are rows of another collection", self._table.label)
        rows = parent.table.rows_of(parent.values)
        if (rows < 0).any():
            raise error("E0709", "a parent was removed", self._table.label)
        return rows

    def _count(self, flat: Mapping[str, Any], owners: Ints | None) -> int:
        """Return the number of rows of the given arrays."""
        for path, value in flat.items():
            column = self._table.data.get(path)
            try:
                shape = value.values.shape if isinstance(value, Handles) else np.shape(value)
            except ValueError:
                raise error(
                    "E0704", "the rows differ in length", f"{self._table.label}.{path}"
                ) from None
            if len(shape) > _rank(column):
                return int(shape[0])
        if owners is not None and owners.ndim:
            return len(owners)
        raise error(
            "E0704",
            "the number of rows is not determined by any array",
            self._table.label,
            help="pass the number first",
        )

    # --- data frames -------------------------------------------------------------------------

    def to_pandas(self) -> pandas.DataFrame:
        """The rows as a pandas DataFrame: a copy.

        One column for each scalar, named as in CSV files: ``pos.x``, ``att.w``, ``m[0][1]``; refs
        are row numbers; of a nested collection ``parent`` is the row of the owner; ``pos.fixed`` if
        a row is fixed. What is absent is missing. ``extend`` takes such a frame.

        Raises AraelError: E0868 pandas is not installed.
        """
        # imported here: start-up time
        from arael.io.frames import to_pandas

        return to_pandas(self)

    def to_xarray(self) -> xarray.Dataset:
        """The rows as an xarray Dataset: a variable (row, ...) for each field, a copy.

        Components have coordinates (``x``, ``y``, ``z``; ``w`` first of quaternions), units are
        attributes, and refs row numbers with -1 for null.

        Raises AraelError: E0868 xarray is not installed.
        """
        # imported here: start-up time
        from arael.io.frames import to_xarray

        return to_xarray(self)

    # --- removing ----------------------------------------------------------------------------

    def popleft(self, n: int = 1) -> None:
        """Remove the first `n` rows of a deque with their nested rows; their refs become stale."""
        self._only("deque", "popleft", "removes at the front")
        if not isinstance(n, int | np.integer) or isinstance(n, bool) or n < 0:
            raise wrong_argument(self._table.label, "n", "a number of rows", n)
        if n > len(self):
            raise IndexError(f"popleft of {n} from {len(self)} rows")
        self._remove(self._every()[:n])

    def pop(self) -> None:
        """Remove the last row with its nested rows."""
        if not len(self):
            raise IndexError("pop from an empty collection")
        self._remove(self._every()[-1:])

    def remove(self, refs: Ref | Refs) -> None:
        """Remove rows of an arena anywhere; other refs stay valid, the order is kept."""
        self._only("arena", "remove", "removes anywhere")
        handles = given.refs(refs)
        if not isinstance(handles, Handles) or handles.table is not self._table:
            raise error("E0710", "the ref is not of this collection", self._table.label)
        rows = self._table.rows_of(np.atleast_1d(handles.values))
        if (rows < 0).any():
            raise error("E0709", "the ref is stale: its row was removed already", self._table.label)
        if self._parent is not None and not np.isin(rows, self._every()).all():
            raise error("E0710", "the ref is not of this collection", self._table.label)
        self._remove(rows)

    def clear(self) -> None:
        """Remove all rows with their nested rows."""
        self._remove(self._every())

    def _only(self, collection: str, method: str, what: str) -> None:
        if self._handles is not None:
            raise error("E0424", "a choice of rows cannot shrink", self._table.label)
        found = self._table.layout.collection
        if found != collection:
            raise error(
                "E0424",
                f"`{method}` of {_with_article(found)}: only {_with_article(collection)} {what}",
                self._table.label,
                help=f"declare it as `{collection} of {self._table.layout.struct}` "
                f"at {self._table.layout.where}",
            )

    def _remove(self, rows: Ints) -> None:
        gone = np.zeros(self._table.size, np.bool_)
        gone[rows] = True
        self._table.remove_rows(gone)

    # --- rows --------------------------------------------------------------------------------

    def __len__(self) -> int:
        rows = self._rows()
        return rows.stop - rows.start if isinstance(rows, slice) else len(np.atleast_1d(rows))

    def __iter__(self) -> Iterator[Ref]:
        for handle in self._table.handles(self._rows()).tolist():
            yield Ref(self._table, handle)

    @property
    def refs(self) -> Refs:
        """Refs to the rows here."""
        return Refs(self._table, self._table.handles(self._rows()))

    def __getitem__(self, index: Any) -> Any:
        """Return a row (by number, `Ref`), some (slice, mask, numbers, `Refs`) or a field."""
        table = self._table
        if type(index) is int and self._handles is None and self._parent is None:
            size = table.buffers.size  # the usual case first: people loop over numbers of rows
            if -size <= index < size:
                return Ref(table, table.handle_of(index if index >= 0 else index + size))
        if isinstance(index, str):
            return super().__getitem__(index)
        if isinstance(index, (Ref, Refs)):
            if index._table is not table:
                raise error("E0710", "the ref is not of this collection", table.label)
            if isinstance(index, Refs):
                return Collection(table, handles=index._handles)
            table.row_of(index._handle)
            return index
        rows = self._rows()
        if isinstance(index, (int, np.integer)) and not isinstance(index, bool):
            count = rows.stop - rows.start if isinstance(rows, slice) else len(np.atleast_1d(rows))
            if not -count <= index < count:
                raise IndexError(f"{table.label}[{index}]: there are {count} rows")
            at = int(index) % count
            row = rows.start + at if isinstance(rows, slice) else np.atleast_1d(rows)[at]
            return Ref(table, table.handle_of(int(row)))
        return Collection(table, handles=table.handles(rows)[index])

    def __contains__(self, ref: object) -> bool:
        if not isinstance(ref, Ref) or ref._table is not self._table or not ref.is_valid:
            return False
        return bool(np.isin(self._table.row_of(ref._handle), self._every()))

    def _sheet(self) -> Sheet:
        # imported here: start-up time
        from arael.face.sheets import collection_sheet

        return collection_sheet(self)

    def __repr__(self) -> str:
        table = self._table
        kind = f"{table.layout.collection} of {table.layout.struct}"
        name = table.label
        if self._parent is not None:
            owner = table.parent.row_of(self._parent)
            name = table.parent.name_of(owner, table.layout.field)
        count = len(self)
        return f"<{kind} {name}: {count} row{'' if count == 1 else 's'}>"


def fill(collection: Collection, items: Any, origin: str) -> None:
    """Append a list of dicts, the rows of a data frame, or those of a dict of arrays."""
    if is_frame(items):
        collection.extend(items)
        return
    if isinstance(items, Mapping):
        if not all(isinstance(name, str) for name in items):
            raise error("E0703", "expected arrays by the names of fields", origin)
        collection.extend(**items)
        return
    if not isinstance(items, (list, tuple)):
        raise error("E0703", "expected a list of dicts, a dict of arrays or a data frame", origin)
    for item in items:
        if not isinstance(item, Mapping):
            raise error("E0703", "expected a list of dicts", origin)
        if not all(isinstance(name, str) for name in item):
            raise error("E0703", "expected values by the names of fields", origin)
        collection.append(**item)


def is_frame(given: object) -> bool:
    """Whether an object has columns by name, as data frames of pandas and polars have them."""
    return hasattr(given, "columns") and hasattr(given, "__getitem__") and hasattr(given, "shape")


def _with_article(collection: str) -> str:
    return f"{'an' if collection == 'arena' else 'a'} {collection}"


def _rank(column: Column | None) -> int:
    """Return number of axes of one value; flags and presence are scalars."""
    return len(column.shape) if column is not None and column.role != "ref" else 0


def _together(rows: Ints) -> Rows:
    """Return the rows as a slice if they are contiguous in memory."""
    if not len(rows):
        return slice(0, 0)
    first, last = int(rows[0]), int(rows[-1])
    if last - first + 1 == len(rows) and (len(rows) == 1 or (np.diff(rows) == 1).all()):
        return slice(first, last + 1)
    return rows


__all__ = ["Collection", "Nested"]
