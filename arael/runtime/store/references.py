"""Refs: from handles or indices to handles, and from handles to rows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import AraelError
from arael.runtime.layout import Column, Step, Target
from arael.runtime.store import keys
from arael.runtime.store.compiled import followed
from arael.runtime.store.messages import Origin, describe, error
from arael.runtime.store.slots import NULL, Ints

if TYPE_CHECKING:
    from arael.runtime.store.table import Table


@dataclass(frozen=True, eq=False)
class Handles:
    """Handles of rows of one table."""

    table: Table
    values: Ints


def walk(table: Table, steps: tuple[Step, ...], rows: Ints) -> tuple[Table, Ints]:
    """Rows reached by `steps` from `rows` of `table`; -1 if a ref on the path is null.

    Raises AraelError (E0709) for a stale ref on the path.
    """
    for step in steps:
        if step.kind == "root":
            table, rows = table.store.tables[""], np.zeros(len(rows), np.int64)
            continue
        known = rows >= 0
        through = rows[known]
        result = np.full(len(rows), NULL, np.int64)
        if step.kind == "parent":
            result[known] = table.parent_rows_of(through)
            table = table.store.tables[table.layout.parent]
        else:
            result[known] = rows_of_ref(table, step.ref, through)
            table = table.store.tables[target_of(table, step.ref).table]
        rows = result
    return table, rows


def target_of(table: Table, path: str) -> Target:
    """Return the target table of the ref column at `path`."""
    target = table.data[path].target
    assert target is not None, path
    return target


def rows_of_ref(table: Table, path: str, rows: Ints | None = None) -> Ints:
    """Dense rows of the target table for some rows of a ref column, or all; -1 where absent.

    Raises AraelError: E0709 for a stale handle, E0702 for a ref that was never set.
    """
    column = table.data[path]
    target = table.store.tables[target_of(table, path).table]
    handles = table.column(path) if rows is None else table.column(path)[rows]
    found = target.rows_of(handles)
    if len(found) and found.min() < 0:
        rows = np.arange(table.size) if rows is None else rows
        bad = found < 0
        absent = ~table.present(path)[rows]
        bad &= ~absent
        found[absent] = NULL
        if bad.any():
            _report(table, column, rows[bad], handles[bad])
    return found


def _report(table: Table, column: Column, rows: Ints, handles: Ints) -> None:
    """Raise for invalid refs: the first by name, the others by count."""
    origin = table.name_of(int(rows[0]), column.path)
    more = f" (and {len(rows) - 1} more)" if len(rows) > 1 else ""
    if handles[0] == NULL:
        raise error("E0702", f"{origin} is not set{more}", origin, column)
    raise error(
        "E0709",
        f"{origin} is stale: the row it pointed to was removed{more}",
        origin,
        column,
        help="first remove the rows that refer to it, or change their refs",
    )


def handles_of(table: Table, column: Column, given: Any, rows: Ints, origin: Origin) -> Ints:
    """Return handles for `rows` of a ref column from `Handles`, indices or keys (as in files).

    Raises AraelError: E0703 wrong type, E0704 wrong length, E0707 null, E0708 out of range, not in
    the target collection or no such key, E0709 stale, E0710 of another table or model, E0718 a key
    of two rows.
    """
    assert column.target is not None
    target = table.store.tables[column.target.table]

    def name(i: int) -> str:
        return f"{origin} (row {i})" if len(rows) > 1 else str(origin)

    if isinstance(given, Handles):
        if given.table is not target:
            raise error("E0710", _foreign(given.table, target), origin, column)
        handles = np.broadcast_to(given.values, _row_shape(given.values, rows, column, origin))
        dense = target.rows_of(handles)
        stale = (dense < 0) & (handles != NULL)
        if stale.any():
            i = int(np.argmax(stale))
            raise error("E0709", "the ref is stale: its row was removed", name(i), column)
    else:
        index = (
            np.asarray(keys.nulls_as_indices(given))
            if not target.layout.key
            else _without_keys(table, column, given, rows, origin, name)
        )
        if index.dtype.kind not in "iu":
            key = f", or its `{target.layout.key}`" if target.layout.key else ""
            raise error(
                "E0703",
                f"expected {ref_words(column)}{key}, found {describe(given)}",
                origin,
                column,
            )
        index = np.broadcast_to(index, _row_shape(index, rows, column, origin)).astype(np.int64)
        dense = from_index(table, column, index, rows, name)
        handles = np.full(len(rows), NULL, np.int64)
        handles[dense >= 0] = target.handles(dense[dense >= 0])
    null = handles == NULL
    if null.any() and not table.ref_is_optional(column):
        i = int(np.argmax(null))
        negative = _is_minus_one(given, i)
        raise error(
            "E0707",
            _negative(column, -1, target.size) if negative else "null where a ref is needed",
            name(i),
            column,
            help="rows are counted from 0; -1 is no row, for refs with `?`" if negative else "",
        )
    if isinstance(given, Handles) and target.layout.parent:
        _, owners = walk(table, column.target.base, rows)
        wrong = (dense >= 0) & (owners != _holders(target, dense))
        if wrong.any():
            i = int(np.argmax(wrong))
            raise error(
                "E0708",
                f"{target.row_name(int(dense[i]))} is not in `{column.target.text}` of this row",
                name(i),
                column,
            )
    return handles


def _is_minus_one(given: Any, row: int) -> bool:
    """Whether the -1 of a row, which means null, was given as a number."""
    if isinstance(given, Handles):
        return False
    values = np.asarray(given, object).ravel()
    value = values[row if values.size > 1 else 0] if values.size else None
    return isinstance(value, int | np.integer)


def _without_keys(
    table: Table, column: Column, given: Any, rows: Ints, origin: Origin, name: Any
) -> NDArray[Any]:
    """The values of a ref column, with keys converted to indices."""
    assert column.target is not None
    if not keys.has_text(given):
        return np.asarray(keys.nulls_as_indices(given))
    texts = keys.as_objects(given)
    texts = np.broadcast_to(texts, _row_shape(texts, rows, column, origin))
    target = table.store.tables[column.target.table]
    _, owners = walk(table, column.target.base, rows)
    return keys.indices(target, column, texts, owners, name)


def ref_words(column: Column) -> str:
    """Describe the expected values of a ref column."""
    assert column.target is not None
    return f"a ref or the index of a `{column.target.struct}` in `{column.target.text}`"


def _row_shape(given: NDArray[Any], rows: Ints, column: Column, origin: Origin) -> tuple[int]:
    if given.shape not in ((), (len(rows),)):
        raise error(
            "E0704",
            f"expected {len(rows)} refs, found an array of shape {given.shape}",
            origin,
            column,
        )
    return (len(rows),)


def _foreign(found: Table, target: Table) -> str:
    if found.layout.path == target.layout.path and found.store is not target.store:
        return "the ref belongs to another model instance"
    return f"the ref points into `{found.label}`, not into `{target.label}`"


def from_index(table: Table, column: Column, index: Ints, rows: Ints, name: Any) -> Ints:
    """Dense target rows from indices within each row's target collection."""
    assert column.target is not None
    target = table.store.tables[column.target.table]
    _, owners = walk(table, column.target.base, rows)
    counts = counts_of(target, owners)
    wrong = (index < NULL) | ((index >= counts) & (index != NULL)) | (owners < 0)
    wrong &= ~((index == NULL) & (owners < 0))
    if wrong.any():
        i = int(np.argmax(wrong))
        raise error("E0708", out_of_range(column, index[i], int(counts[i])), name(i), column)
    dense = np.full(len(index), NULL, np.int64)
    known = index >= 0
    dense[known] = target.child_rows(owners[known], index[known])
    return dense


def counts_of(target: Table, owners: Ints) -> Ints:
    """Number of rows of `target` of each owner; -1 without an owner."""
    counts = np.full(len(owners), NULL, np.int64)
    known = owners >= 0
    counts[known] = target.child_counts()[owners[known]]
    return counts


def out_of_range(column: Column, index: int, count: int) -> str:
    """Message for an index into a collection of `count` rows; -1 for a null base."""
    assert column.target is not None
    if count < 0:
        return f"index {index} is in `{column.target.text}`, but the ref on the path is null"
    if index < 0:
        return _negative(column, index, count)
    rows = f"{count} row{'' if count == 1 else 's'}"
    return f"index {index} is out of range: `{column.target.text}` has {rows}"


def _negative(column: Column, index: int, count: int) -> str:
    assert column.target is not None
    rows = f"{count} row{'' if count == 1 else 's'}"
    return f"index {index} is negative: `{column.target.text}` has {rows}"


def _holders(target: Table, dense: Ints) -> Ints:
    """Dense rows of the owners of some rows of `target`; -1 for -1."""
    found = np.full(len(dense), NULL, np.int64)
    known = dense >= 0
    found[known] = target.parent_rows_of(dense[known])
    return found


def check_owner(table: Table, path: str, dense: Ints) -> None:
    """Raise E0708 if a chained ref points to a row of another owner than its base.

    `dense` are the rows that it points to, as `rows_of_ref` gives them.
    """
    column = table.data[path]
    target = table.store.tables[target_of(table, path).table]
    if not target.layout.parent or not table.size:
        return
    _, owners = walk(table, target_of(table, path).base, np.arange(table.size))
    wrong = (dense >= 0) & (followed(target.parent_rows(), dense) != owners)
    if wrong.any():
        row = int(np.argmax(wrong))
        origin = table.name_of(row, path)
        text = target_of(table, path).text
        raise AraelError(
            error(
                "E0708",
                f"{target.row_name(int(dense[row]))} is not in `{text}` of this row",
                origin,
                column,
            ).diagnostics
        )
