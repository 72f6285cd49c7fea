"""Conversion of refs by `key` text of their target to indices."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import AraelError, Diagnostic
from arael.runtime.layout import Column
from arael.runtime.store.messages import describe, problem, shorten, suggestion
from arael.runtime.store.slots import NULL, Ints

if TYPE_CHECKING:
    from arael.runtime.store.table import Table

MAX_TOLD = 20
"""Errors of one column."""


def has_text(given: Any) -> bool:
    """Whether a ref column contains text."""
    if isinstance(given, np.ndarray) and given.dtype.kind in "UO":
        given = given.tolist()
    if isinstance(given, (list, tuple)):
        return any(isinstance(item, str) for item in given)
    return isinstance(given, str)


def nulls_as_indices(given: Any) -> Any:
    """Indices with -1 in place of None; other values unchanged."""
    if isinstance(given, np.ndarray) and given.dtype.kind == "O" and given.ndim == 1:
        given = given.tolist()
    if isinstance(given, (list, tuple)) and any(item is None for item in given):
        return [NULL if item is None else item for item in given]
    return given


def as_objects(given: Any) -> NDArray[Any]:
    """Keys and indices as an object array, since NumPy would convert 3 to "3"."""
    if isinstance(given, np.ndarray):
        return given.astype(object)
    if isinstance(given, str):
        return np.array(given, object)
    array = np.empty(len(given), object)
    array[:] = list(given)
    return array


def unknown_key(column: Column, target: Table, value: str, known: list[str]) -> tuple[str, str]:
    """Message and help for a key that no row has."""
    assert column.target is not None
    message = f'`{column.target.text}` has no row whose `{target.layout.key}` is "{shorten(value)}"'
    return message, suggestion(value, known) if known else ""


def double_key(key: str) -> str:
    """Message for a key that two rows have."""
    return f'two rows have the key "{shorten(key)}"'


def indices(
    target: Table, column: Column, given: NDArray[Any], owners: Ints, name: Callable[[int], str]
) -> Ints:
    """Indices within the collection of each row's owner, from keys, indices and None.

    Parameters
    ----------
    target : the table whose rows have the keys
    column : the ref column
    given : text, indices or None (n,)
    owners : dense row of the owner of each ref's target collection (n,); -1 if there is none
    name : of a row, for messages

    Raises
    ------
    AraelError
        E0703 neither text nor index, E0708 no row has the key, E0718 two rows have it.
    """
    parents, places = target.parent_rows(), target.index_in_parent()
    holders, every = parents.tolist(), dict[tuple[int, str], list[int]]()
    wanted = {value for value in given.tolist() if isinstance(value, str)}
    for row, key in enumerate(target.column(target.layout.key).tolist()):
        if key in wanted:
            every.setdefault((holders[row], key), []).append(row)
    found = np.full(len(given), NULL, np.int64)
    wrong: list[Diagnostic] = []
    doubled: set[int] = set()
    for i, value in enumerate(given.tolist()):
        if len(wrong) >= MAX_TOLD:
            break
        if value is None:
            continue
        if isinstance(value, (int, np.integer)) and not isinstance(value, bool):
            found[i] = min(max(int(value), -2), 2**62)  # indices out of range are reported later
            continue
        if not isinstance(value, str):
            expected = f"the index of a `{target.layout.struct}` or its `{target.layout.key}`"
            message = f"expected {expected}, found {describe(value)}"
            wrong.append(problem("E0703", message, name(i), column))
            continue
        rows = every.get((int(owners[i]), value), [])
        if not rows:
            mine = target.column(target.layout.key)[parents == owners[i]].tolist()
            message, help_ = unknown_key(column, target, value, mine)
            wrong.append(problem("E0708", message, name(i), column, help_))
            continue
        if len(rows) > 1 and rows[1] not in doubled:
            doubled.add(rows[1])
            where = target.name_of(rows[1], target.layout.key)
            wrong.append(problem("E0718", double_key(value), where, target.data[target.layout.key]))
        found[i] = places[rows[0]]
    if wrong:
        raise AraelError(wrong)
    return found
