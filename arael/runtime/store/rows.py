"""The rows of a table: their handles, owners and names."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from arael.runtime import layout
from arael.runtime.store.columns import Columns, Rows
from arael.runtime.store.messages import error
from arael.runtime.store.slots import Ints, Slots

if TYPE_CHECKING:
    from arael.runtime.store.store import Store
    from arael.runtime.store.table import Table

T = TypeVar("T")
SLOT, PARENT = "#slot", "#parent"
"""Columns of the slot of each row, and of the slot of its owner."""


class RowIndex(Columns):
    """Which row a handle means, which row owns another, and what rows are called in messages.

    Attributes
    ----------
    store : the instance that this table belongs to
    structure_version : changes whenever rows are added or removed, or refs are set
    """

    _slots: Slots

    def __init__(self, store: Store, table: layout.Table) -> None:
        super().__init__(store.layout, table)
        self.store = store
        self.structure_version = 0
        self._cache: dict[str, tuple[Any, Any]] = {}
        self.buffers.add(SLOT, np.int64)
        self.buffers.add(PARENT, np.int64)

    @property
    def label(self) -> str:
        """Path, or the root's struct name."""
        return self.layout.path or self.layout.struct

    @property
    def parent(self) -> Table:
        """The table of the owners of this collection; the root is its own parent."""
        return self.store.tables[self.layout.parent]

    def handles(self, rows: Rows) -> Ints:
        """Return handles of dense rows."""
        return self._slots.handles(np.atleast_1d(self.buffers.view(SLOT)[rows]))

    def handle_of(self, row: int) -> int:
        """Return the handle of one dense row."""
        return self._slots.handle(self.buffers.view(SLOT).item(row))

    def rows_of(self, handles: NDArray[Any]) -> Ints:
        """Dense rows of handles; -1 for null and stale ones."""
        return self._slots.rows(handles, self.buffers.start)

    def is_valid(self, handle: int) -> bool:
        """Whether the row of a handle exists."""
        return self._slots.position(handle) >= 0

    def row_of(self, handle: int) -> int:
        """Dense row of one handle; E0709 if its row was removed."""
        position = self._slots.position(handle)
        if position < 0:
            raise error("E0709", "the ref is stale: its row was removed", self.label)
        return position - self.buffers.start

    def parent_rows(self) -> Ints:
        """Dense row of each row's owner in the parent table (size,)."""
        return self._cached(
            "parents", lambda: self.parent_rows_of(np.arange(self.size)), self.parent
        )

    def parent_rows_of(self, rows: Ints) -> Ints:
        """Dense rows of the owners of some rows."""
        if not self.layout.parent:
            return np.zeros(len(rows), np.int64)
        parent = self.parent
        slots = self.buffers.view(PARENT)[rows]
        return parent._slots.positions_of_slots(slots) - parent.buffers.start

    def grouped(self) -> tuple[Ints, Ints]:
        """Rows by owner: `order` (size,) and `offsets` (parents + 1,).

        ``order[offsets[p]:offsets[p + 1]]`` are the rows nested in row ``p`` of the parent table.
        """
        return self._cached("grouped", self._group, self.parent)

    def _group(self) -> tuple[Ints, Ints]:
        parents = self.parent_rows()
        counts = np.bincount(parents, minlength=self.parent.size if self.layout.path else 1)
        offsets = np.concatenate(([0], np.cumsum(counts))).astype(np.int64)
        return np.argsort(parents, kind="stable").astype(np.int64), offsets

    def child_counts(self) -> Ints:
        """Return the number of nested rows of each row of the parent table."""
        return np.diff(self.grouped()[1])

    def child_rows(self, owners: Ints, index: Ints) -> Ints:
        """Dense rows of the `index`-th rows of `owners` (both in range)."""
        order, offsets = self.grouped()
        return np.asarray(order[offsets[owners] + index])

    def index_in_parent(self) -> Ints:
        """Index of each row within its collection (size,)."""

        def build() -> Ints:
            order, offsets = self.grouped()
            place = np.empty(self.size, np.int64)
            place[order] = np.arange(self.size) - offsets[self.parent_rows()[order]]
            return place

        return self._cached("places", build, self.parent)

    def row_name(self, row: int) -> str:
        """Name of a row: ``landmarks[5].frines[2]``; "" for the root."""
        if not self.layout.path:
            return ""
        if not self.layout.parent:
            return f"{self.layout.path}[{row}]"
        owner = self.parent.row_name(int(self.parent_rows()[row]))
        return f"{owner}.{self.layout.field}[{self.index_in_parent()[row]}]"

    def row_names(self, rows: Ints) -> list[str]:
        """Names of several rows, as `row_name` gives them."""
        if not self.layout.path:
            return [""] * len(rows)
        if not self.layout.parent:
            return [f"{self.layout.path}[{row}]" for row in rows.tolist()]
        owners, inverse = np.unique(self.parent_rows()[rows], return_inverse=True)
        names, field = self.parent.row_names(owners), self.layout.field
        places = self.index_in_parent()[rows].tolist()
        return [
            f"{names[owner]}.{field}[{place}]"
            for owner, place in zip(inverse.tolist(), places, strict=True)
        ]

    def name_of(self, row: int, path: str) -> str:
        """Name of a field of a row: ``poses[3].ea``; for the root ``gamma``."""
        name = self.row_name(row)
        return f"{name}.{path}" if name else path

    def _origin_of_new(self, owners: Ints | None, many: bool, before: int) -> str:
        """Names of new rows, in place or not; `before` is the previous number of rows."""
        if not self.layout.path:
            return self.layout.struct
        if self.layout.parent:
            if owners is None or not len(owners) or (owners != owners[0]).any():
                return self.layout.path
            owner = int(owners[0])
            base = f"{self.parent.row_name(owner)}.{self.layout.field}"
            index = self.child_counts()[owner] - (self.size - before)
            return base if many else f"{base}[{index}]"
        return self.layout.path if many else f"{self.layout.path}[{before}]"

    def _cached(self, name: str, build: Callable[[], T], other: Table | Store) -> T:
        """Return a derived array, cached until this table or `other` changes its structure."""
        version = (self.structure_version, other.structure_version)
        known = self._cache.get(name)
        if known is not None and known[0] == version:
            return known[1]  # type: ignore[no-any-return]
        value = build()
        self._cache[name] = (version, value)
        return value
