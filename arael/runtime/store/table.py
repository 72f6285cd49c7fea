"""A table: the rows of one collection (or the root): adding, removing, refs."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from contextlib import AbstractContextManager
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import AraelError
from arael.runtime import layout
from arael.runtime.store import keys, references
from arael.runtime.store.bounds import ENDS
from arael.runtime.store.columns import flags_of
from arael.runtime.store.messages import Name, Origin, below, error
from arael.runtime.store.plain_rows import PlainRows
from arael.runtime.store.references import Handles
from arael.runtime.store.rows import PARENT, SLOT, RowIndex
from arael.runtime.store.schema import Group
from arael.runtime.store.slots import NULL, Ints, Slots
from arael.runtime.store.values import blank, default_value, dtype_of

if TYPE_CHECKING:
    from arael.runtime.store.store import Store


class Table(RowIndex):
    """Rows of one collection of the whole model instance, dense and in order.

    Rows of a nested collection are in order of creation; `grouped` returns them by parent.

    Attributes
    ----------
    store : the instance that this table belongs to
    layout : its layout by the compiler
    structure_version : changes whenever rows are added or removed, or refs are set
    """

    def __init__(self, store: Store, table: layout.Table, first_generation: int = 0) -> None:
        super().__init__(store, table)
        self.data_version: int | None = None  # not counted: Python writes through views
        self.values_version: int | None = None
        self._slots = Slots(first_generation)
        self.children = [
            t.path for t in store.layout.tables if t is not table and t.parent == table.path
        ]
        refs = [c for c in self.data.values() if c.role == "ref" and c.target is not None]
        # A chained ref is resolved after those it depends on.
        self._ref_order = [c.path for c in sorted(refs, key=lambda c: len(_chain(c, self.data)))]

    @property
    def next_generation(self) -> int:
        """A generation that no handle of this table has."""
        return self._slots.next_generation

    def written(self) -> None:
        """Do nothing: writes to columns are not counted."""

    # --- adding ------------------------------------------------------------------------------

    def append(self, parent: int | None = None, /, *, front: bool = False, **values: Any) -> int:
        """Add one row and return its handle; `parent` is the dense row of its owner.

        Raises AraelError as `extend` does.
        """
        owners = None if parent is None else np.array([parent], np.int64)
        return int(self._add(1, owners, values, many=False, front=front)[0])

    def append_plain(
        self, values: Mapping[str, Any], handles: Mapping[str, int], parent: int | None
    ) -> int | None:
        """Add one row of plain values and return its handle; None, without a change, for others.

        The values are by field name; `handles` are those of the refs among them. See `PlainRows`.

        Raises AraelError: E1040 the instance is being solved.
        """
        row = self.plain_rows.row(values, handles)
        if row is None:
            return None
        with self._changing("add rows to"):
            buffers = self.buffers
            moved = buffers.grow_back(1)
            at = buffers.start + buffers.size - 1
            row[SLOT], handle = self._slots.take_one(at)
            row[PARENT] = 0 if parent is None else self.parent.buffers.view(SLOT)[parent]
            buffers.put(at, row)
            if moved:
                self._renumber()
            self._touch()
        return handle

    @cached_property
    def plain_rows(self) -> PlainRows:
        """The columns in which `append_plain` stores."""
        return PlainRows(self)

    def extend(
        self, n: int, /, parent_rows: Any = None, *, front: bool = False, **columns: Any
    ) -> Ints:
        """Add `n` rows and return their handles (n,).

        Parameters
        ----------
        n : number of rows
        parent_rows : dense rows of the owners, (n,) or one for all; needed in a nested collection
        front : add before the first row (of a deque)
        **columns : by path (``**{"info.tilt_roll": T}``), each (n, *shape) or one value for all

        Raises
        ------
        AraelError
            E0701 unknown field, E0702 missing, E0703-E0706 wrong values, E0707-E0710 wrong refs,
            E1040 the instance is being solved. The table is then unchanged.
        """
        owners = None
        if parent_rows is not None:
            owners = np.broadcast_to(np.asarray(parent_rows, np.int64), (n,))
        return self._add(n, owners, columns, many=True, front=front)

    def _add(
        self, count: int, owners: Ints | None, given: Mapping[str, Any], many: bool, front: bool
    ) -> Ints:
        if front and self.layout.collection != "deque":
            raise self._refusal("only a deque grows at the front")
        with self._changing("add rows to"):
            return self._add_checked(count, owners, given, many, front)

    def _add_checked(
        self, count: int, owners: Ints | None, given: Mapping[str, Any], many: bool, front: bool
    ) -> Ints:
        if self.layout.parent:
            if owners is None:
                raise self._refusal("rows of a nested collection need their parent")
            if count and not ((owners >= 0) & (owners < self.parent.size)).all():
                raise self._refusal("parent row out of range")
        before = self.size
        origin = Name(lambda: self._origin_of_new(owners, many, before))
        ready = self.prepare(given, count, many, origin)
        first = 0 if front else self.size
        slots = self._place(count, owners, ready, front)
        try:
            for path in self._ref_order:
                if given.get(path) is not None:
                    self._put_refs(
                        path, np.arange(first, first + count), given[path], below(origin, path)
                    )
                if given.get(path) is not None and given.get(f"{path}?") is not None:
                    absent = first + np.flatnonzero(~np.broadcast_to(ready[f"{path}?"], (count,)))
                    self._put_refs(path, absent, NULL, below(origin, path))
        except BaseException:
            self._take_back(slice(first, first + count))
            raise
        return self._slots.handles(slots)

    def _place(
        self, count: int, owners: Ints | None, ready: Mapping[str, NDArray[Any]], front: bool
    ) -> Ints:
        """Allocate new rows, fill them and return their slots."""
        first = 0 if front else self.size
        moved = self.buffers.grow_front(count) if front else self.buffers.grow_back(count)
        rows = slice(first, first + count)
        slots = self._slots.take(count)
        self.buffers.view(SLOT)[rows] = slots
        self._slots.move(slots, np.arange(first, first + count) + self.buffers.start)
        if moved:
            self._renumber()
        self.buffers.view(PARENT)[rows] = (
            self.parent.buffers.view(SLOT)[owners] if self.layout.parent else 0
        )
        self.fill(rows, ready)
        self._touch()
        return slots

    def blank_column(self, path: str, count: int) -> NDArray[Any]:
        """Return an array (count, *shape) of the default or else of neutral values."""
        column = self.data[path]
        value = blank(column) if column.default is None else default_value(column)
        array = np.empty((count, *column.shape), dtype_of(column, self.real))
        array[:] = value
        return array

    def extend_trusted(
        self, count: int, owners: Ints | None, columns: Mapping[str, NDArray[Any]]
    ) -> None:
        """Add rows of checked arrays by path; missing columns are blank, refs are null."""
        ready: dict[str, NDArray[Any]] = {f"{p}?": np.asarray(False) for p in self.optionals}
        for path, column in self.data.items():
            value = blank(column) if column.default is None else default_value(column)
            ready[path] = np.asarray(value, dtype_of(column, self.real))
            if column.role == "param":
                ready[f"{path}.fixed"] = np.asarray(False)
                ready.update(self.flags_of_new(column))
        with self._changing("add rows to"):
            self._place(count, owners, {**ready, **columns}, False)

    def _take_back(self, rows: slice) -> None:
        keep = np.ones(self.size, np.bool_)
        keep[rows] = False
        self.remove_rows(~keep)

    def make_single_row(self, values: Mapping[str, Any]) -> None:
        """Create the root's row from trusted values."""
        self.buffers.grow_back(1)
        slots = self._slots.take(1)
        self._slots.move(slots, 0)
        self.buffers.view(SLOT)[0] = slots[0]
        self.buffers.view(PARENT)[0] = 0
        for path, column in self.data.items():
            self.buffers.view(path)[0] = values.get(path, NULL)
            if column.role == "param":
                self.fixed(path)[0] = False
                for flag in flags_of(column):
                    self.buffers.view(flag)[0] = True
        for path in self.optionals:
            self.buffers.view(f"{path}?")[0] = False
        self._touch()

    def with_descendants(self) -> list[Table]:
        """Return this table and all tables nested in it."""
        found = [self]
        for path in self.children if self.layout.path else ():
            found += self.store.tables[path].with_descendants()
        return found

    def snapshot(self) -> Any:
        """Return a copy of rows and handles, for `restore`."""
        return copy.deepcopy((self.buffers, self._slots, self.missing))

    def restore(self, state: Any) -> None:
        """Restore a `snapshot`; handles that were valid then are valid again."""
        with self._changing("replace the rows of"):
            self.buffers, self._slots, self.missing = state
            self._cache.clear()
            self._touch()

    def take_over(self, other: Table) -> None:
        """Take the content of `other` (of a store of `Store.fresh`), which is then invalid."""
        self.buffers, self._slots, self.missing = other.buffers, other._slots, other.missing
        self._cache.clear()
        self._touch()

    # --- removing ----------------------------------------------------------------------------

    def retire_front(self, count: int = 1) -> None:
        """Remove the first `count` rows with their nested rows; no other row moves in memory."""
        if count <= 0:
            return
        with self._changing("remove rows of"):
            gone = np.zeros(self.size, np.bool_)
            gone[:count] = True
            self.remove_rows(gone)

    def remove(self, handle: int) -> None:
        """Remove one row with its nested rows by its handle; E0709 if it is stale."""
        with self._changing("remove rows of"):
            gone = np.zeros(self.size, np.bool_)
            gone[self.row_of(handle)] = True
            self.remove_rows(gone)

    def clear(self) -> None:
        """Remove all rows with their nested rows."""
        with self._changing("remove rows of"):
            self.remove_rows(np.ones(self.size, np.bool_))

    def remove_rows(self, gone: NDArray[np.bool_]) -> None:
        """Remove the rows of a mask (size,) with their nested rows; order is kept.

        Raises AraelError: E1040 while the instance is being solved.
        """
        if gone.any():
            with self._changing("remove rows of"):
                self._remove_rows(gone)

    def _remove_rows(self, gone: NDArray[np.bool_]) -> None:
        for path in self.children:
            child = self.store.tables[path]
            child.remove_rows(gone[child.parent_rows()])
        self._slots.release(self.buffers.view(SLOT)[gone].copy())
        count = int(gone.sum())
        if gone[:count].all():
            self.buffers.drop_front(count)
        else:
            self.buffers.keep(~gone)
            self._renumber()
        self._touch()

    def _renumber(self) -> None:
        self._slots.move(
            self.buffers.view(SLOT), np.arange(self.size, dtype=np.int64) + self.buffers.start
        )

    def _changing(self, what: str) -> AbstractContextManager[None]:
        """Lock the instance for a change of rows or refs; E1040 while it is being solved."""
        return self.store.use.changing(f"{what} `{self.label}`")

    def _touch(self) -> None:
        self.structure_version = self.store.next_version()

    def _refusal(self, message: str) -> AraelError:
        return error("E0424", message, self.label)

    # --- refs --------------------------------------------------------------------------------

    def present(self, path: str) -> NDArray[np.bool_]:
        """Whether `path` and its enclosing optionals are present in each row (size,).

        An optional ref whose target was removed is absent, like a null one.
        """
        found = super().present(path)
        column = self.data.get(path) if path in self.optionals else None
        if column is not None and column.role == "ref":
            target = self.store.tables[references.target_of(self, path).table]
            found &= target.rows_of(self.buffers.view(path)) >= 0
        return found

    def target_rows(self, path: str) -> Ints:
        """Dense row in the target table for each row of a ref column (size,); -1 where absent.

        Raises
        ------
        AraelError
            E0709 a stale ref, E0702 one never set, E0708 one that contradicts its base; by name.
        """

        def build() -> Ints:
            found = references.rows_of_ref(self, path)
            references.check_owner(self, path, found)
            return found

        return self._cached(f"target {path}", build, self.store)

    def set_refs(self, path: str, rows: Ints, given: Handles | Any, origin: Origin) -> None:
        """Set refs of some rows to `Handles`, or to indices as in data files.

        Raises AraelError: E0703-E0710, nothing is set then; E1040 while the instance is being
        solved.
        """
        with self._changing("set refs of"):
            self._put_refs(path, rows, given, origin)
            self._touch()

    def _put_refs(self, path: str, rows: Ints, given: Handles | Any, origin: Origin) -> None:
        column = self.data[path]
        ancestors = self.present(path)[rows] if path not in self.optionals else None
        if ancestors is not None and not ancestors.all():
            rows, given = rows[ancestors], _subset(given, ancestors)
        handles = references.handles_of(self, column, given, rows, origin)
        self.column(path)[rows] = handles
        self.missing.discard(path)
        if path in self.optionals:
            self.buffers.view(f"{path}?")[rows] = handles != NULL

    def set_group(self, group: Group, row: int, values: Mapping[str, Any]) -> None:
        """Write fields of a struct held by value in one row, by path.

        If the struct was absent all its values are required; otherwise missing ones are unchanged.
        The row is unchanged if a value or ref is wrong.

        Raises AraelError: as `extend`.
        """
        with self._changing("set a struct of"):
            self._set_group(group, row, values)

    def _set_group(self, group: Group, row: int, values: Mapping[str, Any]) -> None:
        inside = f"{group.path}."
        origin = Name(lambda: self.row_name(row) or self.layout.struct)
        full = dict(values)
        if group.optional:
            full[f"{group.path}?"] = True
        if self.present(group.path)[row]:
            self._keep_rest(full, row, inside)
        ready = self.prepare(full, 1, False, origin, inside)
        refs = [p for p in self._ref_order if p.startswith(inside) and full.get(p) is not None]
        # The target collection of a ref may depend on another ref of the same struct, so refs are
        # set and checked in place, and all are restored after an error.
        flags = [f"{path}?" for path in refs if f"{path}?" in self.buffers]
        written = dict.fromkeys([*ready, *refs, *flags])
        before = {path: self.writable(path)[row : row + 1].copy() for path in written}
        missing = set(self.missing)
        try:
            for path, array in ready.items():
                self.writable(path)[row] = array
                self.missing.discard(path)
            for path in refs:
                self._put_refs(path, np.array([row]), full[path], below(origin, path))
        except BaseException:
            for path, value in before.items():
                self.buffers.view(path)[row : row + 1] = value
            self.missing = missing
            raise
        self._touch()

    def _keep_rest(self, given: dict[str, Any], row: int, below: str) -> None:
        """Add to `given` the current values of a row below a struct that are not given."""
        for path in self.optionals:
            if path.startswith(below) and f"{path}?" not in given:
                said = any(p == path or p.startswith(f"{path}.") for p in given)
                given[f"{path}?"] = said or bool(self.present(path)[row])
        for path, column in self.data.items():
            if not path.startswith(below) or not self.present(path)[row]:
                continue
            if column.role == "param":
                self._keep_flags(given, path, row)
            value: Any = self.column(path)[row]
            if column.role == "ref":
                value = Handles(self.store.tables[references.target_of(self, path).table], value)
            given.setdefault(path, value)

    def _keep_flags(self, given: dict[str, Any], path: str, row: int) -> None:
        """Add to `given` the current flag and bounds of a parameter that are not given."""
        some = self.fixed_components(path)
        fixed = bool(self.fixed(path)[row])
        if some is not None and not fixed and some[row].any():
            given.setdefault(f"{path}.fixed", some[row].copy())
        given.setdefault(f"{path}.fixed", fixed)
        for end in ENDS:
            own = self.bound(path, end)
            if own is not None:
                given.setdefault(f"{path}.{end}", own[row].copy())

    def ref_is_optional(self, column: layout.Column) -> bool:
        """Whether the ref may be null."""
        return column.path in self.optionals


def _chain(column: layout.Column, columns: Mapping[str, layout.Column]) -> list[str]:
    """Refs of the same row that a ref depends on, recursively."""
    through: list[str] = []
    for step in column.target.base if column.target else ():
        if step.kind != "ref":
            break
        through.append(step.ref)
        if step.ref in columns and step.ref != column.path:
            through += _chain(columns[step.ref], columns)
        break
    return through


def _subset(given: Any, mask: NDArray[np.bool_]) -> Any:
    if isinstance(given, Handles):
        values = given.values
        return Handles(given.table, values[mask] if values.ndim else values)
    array = keys.as_objects(given) if keys.has_text(given) else np.asarray(given)
    return array[mask] if array.shape == mask.shape else array
