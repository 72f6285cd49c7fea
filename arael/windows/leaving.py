"""Which rows leave a model: those given, rows nested in them, and rows that refer to them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.face.collection import Collection
from arael.face.ref import Ref, Refs
from arael.residuals.messages import error
from arael.runtime.store import Store, Table

Masks = dict[str, NDArray[np.bool_]]
"""Per table path, a mask (size,) of rows."""


def leaving_rows(store: Store, given: Any) -> Masks:
    """Masks of all rows that leave with the rows `given`.

    Rows nested in them leave, and rows without parameters that refer to one of them by a ref that
    is never null: observations of what leaves. Optional refs will be null.

    Raises
    ------
    AraelError
        E0709 a stale ref; E0780 not rows of this model; E0781 a row with parameters refers to a
        row that leaves.
    """
    gone = {path: np.zeros(table.size, np.bool_) for path, table in store.tables.items()}
    for part in _parts(given):
        table, rows = _rows(store, part)
        _mark(store, gone, table, rows)
    solved = _with_parameters(store)
    changed = True
    while changed:
        changed = False
        for path, table in store.tables.items():
            for column in table.data.values():
                if column.role != "ref" or column.target is None:
                    continue
                target = gone[column.target.table]
                if not target.any() or not table.size or table.ref_is_optional(column):
                    continue
                there = table.present(column.path)
                aim = store.tables[column.target.table]
                rows = np.where(there, aim.rows_of(table.column(column.path)), -1)
                users = np.flatnonzero((rows >= 0) & target[rows] & ~gone[path])
                if not len(users):
                    continue
                if not path or path in solved:
                    raise _still_used(store, table, column.path, int(users[0]), rows)
                _mark(store, gone, table, users)
                changed = True
    return gone


def remove(store: Store, gone: Mapping[str, NDArray[np.bool_]]) -> None:
    """Remove rows in the order of tables; nested ones leave with their owners."""
    handles = {
        path: store.tables[path].handles(np.flatnonzero(mask))
        for path, mask in gone.items()
        if mask.any()
    }
    for path, which in handles.items():
        table = store.tables[path]
        rows = table.rows_of(which)
        mask = np.zeros(table.size, np.bool_)
        mask[rows[rows >= 0]] = True
        table.remove_rows(mask)


def _parts(given: Any) -> list[Any]:
    if isinstance(given, Ref | Refs | Collection):
        return [given]
    if not isinstance(given, Iterable) or isinstance(given, str | bytes | Mapping):
        raise _no_rows(given)
    return list(given)


def _rows(store: Store, part: Any) -> tuple[Table, NDArray[np.int64]]:
    if not isinstance(part, Ref | Refs | Collection):
        raise _no_rows(part)
    table = part._table
    if table.store is not store:
        raise error("E0780", f"the rows of `{table.label}` are of another model", "marginalise")
    if isinstance(part, Collection):
        rows = part._rows()
        return table, np.arange(table.size)[rows] if isinstance(rows, slice) else np.asarray(rows)
    handles = np.atleast_1d(part._handle if isinstance(part, Ref) else part._handles)
    rows = table.rows_of(handles)
    if (rows < 0).any():
        raise error("E0709", "the ref is stale: its row was removed already", table.label)
    return table, rows


def _mark(store: Store, gone: Masks, table: Table, rows: NDArray[np.int64]) -> None:
    """Mark rows, and the rows nested in them."""
    gone[table.layout.path][rows] = True
    for path in table.children if table.layout.path else ():
        child = store.tables[path]
        nested = np.flatnonzero(gone[table.layout.path][child.parent_rows()])
        if len(nested):
            _mark(store, gone, child, nested)


def _with_parameters(store: Store) -> set[str]:
    """Tables whose rows, or rows nested in them, have parameters."""
    found = set()
    for entity in store.layout.entities:
        path = entity.table
        while path and entity.tangent:
            found.add(path)
            path = store.tables[path].layout.parent
    return found


def _still_used(
    store: Store, table: Table, column: str, user: int, rows: NDArray[np.int64]
) -> Exception:
    target = table.data[column].target
    assert target is not None
    name = store.tables[target.table].row_name(int(rows[user]))
    who = table.row_name(user)
    return error(
        "E0781",
        f"`{table.name_of(user, column)}` refers to `{name}`, which leaves",
        "marginalise",
        f"marginalise `{who}` too, or declare the ref as optional, `{column}: ref ...?`, with "
        f"constraints `when {column}`"
        if who
        else f"set `{column}` to another row first",
    )


def _no_rows(given: Any) -> Exception:
    return error(
        "E0780",
        f"expected rows of the model, found {type(given).__name__}",
        "marginalise",
        "give refs or a choice of rows: `model.marginalise(model.poses[:2])`",
    )
