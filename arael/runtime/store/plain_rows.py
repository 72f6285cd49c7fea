"""Rows of plain values, added one at a time.

`Table.append` converts values in any of their forms, for many rows as for one. A loop over rows
gives numbers and lists of numbers, nearly always: these are checked and stored here, in a quarter
of the time. What is not plain, or wrong, is left to `Table.append`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from arael.runtime.layout import Column
from arael.runtime.store.bounds import COMPONENTS_FIXED, ENDS
from arael.runtime.store.columns import COMPONENTS
from arael.runtime.store.manifolds import kind_of
from arael.runtime.store.slots import NULL
from arael.runtime.store.values import blank, default_value

if TYPE_CHECKING:
    from arael.runtime.store.table import Table

_LARGEST = 1e300
_LARGEST_INT = 2**53


class PlainRows:
    """The columns of a table in which plain values can be stored.

    Attributes
    ----------
    refs : by path, the table to whose rows a ref points, wherever their owner is
    """

    def __init__(self, table: Table) -> None:
        self._table = table
        self._values: dict[str, Column] = {}
        self.refs: dict[str, Table] = {}
        self._blank: dict[str, Any] = {f"{path}?": False for path in table.optionals}
        needed = set()
        for path, column in table.data.items():
            self._blank[path] = blank(column) if column.default is None else default_value(column)
            if column.role == "param":
                self._blank[f"{path}.fixed"] = False
            optional = any(path == o or path.startswith(f"{o}.") for o in table.optionals)
            if column.role == "ref":
                self._blank[path] = NULL
                target = table.store.tables[column.target.table] if column.target else None
                if target is not None and not target.layout.parent and not optional:
                    self.refs[path] = target
            elif "." not in path and not optional and _is_plain(column, table.real):
                self._values[path] = column
            if not optional and column.role != "constraint_index" and column.default is None:
                needed.add(path)
        self._needed = frozenset(needed)
        # With bounds and flags of rows a table has more columns, which the general way fills.
        more = (*(f".{end}" for end in ENDS), f".{COMPONENTS_FIXED}", COMPONENTS)
        added = any(f"{path}{what}" in table.buffers for path in table.data for what in more)
        self._declared = -1 if added else len(table.buffers)

    def row(self, values: Mapping[str, Any], handles: Mapping[str, int]) -> dict[str, Any] | None:
        """Values of all columns of a new row, or None if one is not plain or is missing.

        Parameters
        ----------
        values : by field name
        handles : those of refs, which are in `values` too
        """
        table = self._table
        if len(table.buffers) != self._declared or not self._needed <= values.keys():
            return None
        for name, value in values.items():
            column = self._values.get(name)
            if column is None:
                if name not in handles or not self.refs[name].is_valid(handles[name]):
                    return None
            elif not _fits(column, value):
                return None
        return {**self._blank, **table.optimize_new, **values, **handles}


def _is_plain(column: Column, real: np.dtype[Any]) -> bool:
    """Whether numbers of the shape of the column are stored as they are."""
    if column.kind == "real":
        return real == np.float64 and kind_of(column) in ("", "euler")
    return column.kind in ("int", "bool") and not column.shape


def _fits(column: Column, value: Any) -> bool:
    """Whether `value` is a finite number, or a list or array of them, of the column's shape."""
    shape = column.shape
    if column.kind == "bool":
        return type(value) is bool
    if column.kind == "int":
        return type(value) is int and -_LARGEST_INT < value < _LARGEST_INT
    if isinstance(value, np.ndarray):
        return value.dtype == np.float64 and value.shape == shape and bool(np.isfinite(value).all())
    if not shape:
        items: Sequence[Any] = (value,)
    elif isinstance(value, (list, tuple)) and shape == (len(value),):
        items = value
    else:
        return False
    for item in items:
        if not (isinstance(item, float) or type(item) is int):  # a bool is an int, but no number
            return False
        if not -_LARGEST < item < _LARGEST:
            return False
    return True
