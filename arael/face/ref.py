"""Handles to rows with attribute access to their fields."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from arael.face.fields import Fields, summary
from arael.runtime.store import Table
from arael.runtime.store.columns import Rows

Ints = NDArray[np.int64]


class Ref(Fields):
    """A handle to a row, valid when the row moves: ``poses[3]``, or a result of ``append``.

    Fields are attributes: ``ref.pos.value``, ``ref.info.gps``. Fields named ``row``, ``index``,
    ``name`` or ``is_valid`` take precedence over the properties.

    Raises AraelError (E0709) on any use after the row was removed.
    """

    def __init__(self, table: Table, handle: int) -> None:
        own = self.__dict__  # `__setattr__` is for fields
        own["_table"], own["_group"], own["_handle"] = table, table.fields, handle

    def _rows(self) -> Rows:
        return self._table.row_of(self._handle)

    def _field(self, name: str) -> Any:
        return self._get(self._group.members[name])

    def _is_there(self) -> bool:
        return self._table.is_valid(self._handle)

    @property
    def row(self) -> int:
        """Row number in the table, the index into columns of `Collection`."""
        if "row" in self._group.members:
            return self._field("row")  # type: ignore[no-any-return]
        return self._table.row_of(self._handle)

    @property
    def index(self) -> int:
        """Index within its collection."""
        if "index" in self._group.members:
            return self._field("index")  # type: ignore[no-any-return]
        return int(self._table.index_in_parent()[self._table.row_of(self._handle)])

    @property
    def is_valid(self) -> bool:
        """Whether the row still exists."""
        if "is_valid" in self._group.members:
            return self._field("is_valid")  # type: ignore[no-any-return]
        return self._table.is_valid(self._handle)

    @property
    def name(self) -> str:
        """Name of the row: ``landmarks[5].frines[2]``."""
        if "name" in self._group.members:
            return self._field("name")  # type: ignore[no-any-return]
        return self._table.row_name(self._table.row_of(self._handle))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Ref):
            return NotImplemented
        return self._table is other._table and self._handle == other._handle

    def __hash__(self) -> int:
        return hash((id(self._table), self._handle))

    def __repr__(self) -> str:
        if not self._table.is_valid(self._handle):
            return f"<stale ref into {self._table.label}>"
        name = self._table.row_name(self._table.row_of(self._handle))
        return f"<{self._group.struct} {name}: {summary(self)}>"


class Refs:
    """Refs to many rows of one collection."""

    __slots__ = ("_handles", "_table")

    def __init__(self, table: Table, handles: Ints) -> None:
        self._table = table
        self._handles = handles

    @property
    def rows(self) -> Ints:
        """Dense rows (n,); -1 where null or stale."""
        return self._table.rows_of(self._handles)

    @property
    def index(self) -> Ints:
        """Indices within their collections (n,), those of a nested one within their owner's.

        -1 where null or stale.
        """
        rows = self.rows
        found = np.full(len(rows), -1, np.int64)
        found[rows >= 0] = self._table.index_in_parent()[rows[rows >= 0]]
        return found

    @property
    def is_valid(self) -> NDArray[np.bool_]:
        """Whether each row still exists (n,)."""
        return self.rows >= 0

    def __len__(self) -> int:
        return len(self._handles)

    @overload
    def __getitem__(self, index: int | np.integer[Any]) -> Ref | None: ...
    @overload
    def __getitem__(self, index: slice | NDArray[Any]) -> Refs: ...
    def __getitem__(self, index: Any) -> Ref | Refs | None:
        """One ref (None if null), or a selection of them."""
        picked = self._handles[index]
        if isinstance(picked, np.ndarray):
            return Refs(self._table, picked)
        return Ref(self._table, int(picked)) if picked >= 0 else None

    def __iter__(self) -> Iterator[Ref | None]:
        for handle in self._handles.tolist():
            yield Ref(self._table, handle) if handle >= 0 else None

    def __repr__(self) -> str:
        return f"<{len(self)} refs into {self._table.label}>"
