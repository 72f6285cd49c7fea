"""What a file or a model has no place for: warnings of readers, listings for conversions."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.model_warnings import DataWarning
from arael.diagnostics.records import Diagnostic
from arael.runtime.store import Store, Table, rotations
from arael.runtime.store.bounds import ENDS, of_model
from arael.runtime.store.manifolds import kind_of
from arael.runtime.store.values import default_value

if TYPE_CHECKING:
    from arael.runtime.layout import Column

Array = NDArray[Any]
RELATIVE = 1e-9
"""Differences below this, relative to the largest number of a column, are rounding."""


def warn(message: str, name: str) -> None:
    """Issue a warning W0701 about a file."""
    # imported here: start-up time
    from arael.diagnostics.render import render

    found = Diagnostic("W0701", message, origin=name, severity="warning")
    warnings.warn(render([found]).rstrip("\n"), DataWarning, stacklevel=4)


def warn_of_loss(lost: Sequence[str], name: str) -> None:
    """Warn of what a model has no field for, if there is anything."""
    if lost:
        warn(f"the model has no field for {listed(lost)}", name)


def listed(parts: Iterable[str]) -> str:
    """``a, b and c``."""
    *most, last = parts
    return f"{', '.join(most)} and {last}" if most else last


# --- conversions ---------------------------------------------------------------------------------


def beside(store: Store, kept: Table, paths: Iterable[str]) -> list[str]:
    """List the data of a store that is not in the fields `paths` of the collection `kept`.

    Values that are the defaults of the model are not listed. A path ``pos.fixed`` keeps the flags,
    ``pos.low`` and ``pos.high`` the bounds.
    """
    held = set(paths)
    found = []
    for table in store.tables.values():
        if table.layout.path and table is not kept:
            if table.size:
                found.append(f"`{table.layout.path}` ({rows(table.size)})")
            continue
        for path, column in table.data.items():
            if column.role == "constraint_index" or (table is kept and path in held):
                pass
            elif not _is_default(table, column):
                found.append(f"`{_full(table, path)}`")
            if column.role == "param":
                found += [
                    f"`{_full(table, name)}` ({rows(count)})"
                    for name, count in _own(table, column).items()
                    if count and not (table is kept and name in held)
                ]
    return found


def _own(table: Table, column: Column) -> dict[str, int]:
    """Numbers of rows with flags and bounds of their own, by name."""
    found = {f"{column.path}.fixed": int(_flags(table, column).any(axis=1).sum())}
    for end in ENDS:
        own = table.bound(column.path, end)
        differs = np.zeros(1) if own is None else own != of_model(column, end)
        found[f"{column.path}.{end}"] = int(differs.reshape(len(differs), -1).any(axis=1).sum())
    return found


def rows(count: int) -> str:
    """``1 row``, ``2 rows``."""
    return f"{count} row" if count == 1 else f"{count} rows"


def _full(table: Table, path: str) -> str:
    return f"{table.layout.path}.{path}" if table.layout.path else path


def _is_default(table: Table, column: Column) -> bool:
    there = table.present(column.path)
    if column.role == "ref" or not there.any():
        return not there.any()
    if column.default is None:
        return not table.layout.path and column.path in table.missing
    return bool(np.all(table.column(column.path)[there] == default_value(column)))


def differences(store: Store, again: Store) -> list[str]:
    """List the data of a store that another of the same model, read from a file, does not have.

    Numbers are equal up to rounding (`RELATIVE`), and quaternions up to their sign.
    """
    found = []
    for path, table in store.tables.items():
        other = again.tables[path]
        if table.size != other.size:
            lacks = f"{rows(table.size)}, {other.size} remain"
            found.append(f"`{path}` ({lacks})")
            continue
        if table.layout.parent and not np.array_equal(table.parent_rows(), other.parent_rows()):
            found.append(f"the rows that own those of `{path}`")
        found += [f"`{_full(table, name)}`" for name in _changed(table, other)]
    return found


def _changed(table: Table, other: Table) -> Iterator[str]:
    for path, column in table.data.items():
        if column.role == "constraint_index":
            continue
        there = table.present(path)
        if not np.array_equal(there, other.present(path)):
            yield f"{path}?"
            continue
        if column.role == "ref":
            same = np.array_equal(table.target_rows(path), other.target_rows(path))
        elif path in table.missing:
            same = path in other.missing
        else:
            same = _agree(column, table.column(path)[there], other.column(path)[there])
        if not same:
            yield path
        if column.role != "param":
            continue
        flags, kept = _flags(table, column), _flags(other, column)
        if not np.array_equal(flags, kept):
            yield f"{path}.fixed"
        for end in ENDS:
            if not np.array_equal(_bounds(table, column, end), _bounds(other, column, end)):
                yield f"{path}.{end}"


def _flags(table: Table, column: Column) -> Array:
    """Flags (size, k) of the components of a parameter that the data fixes."""
    # imported here: start-up time
    from arael.io.json_writer import fixed_flags

    flags = fixed_flags(table, column)
    k = 1 if column.param is None else column.param.tangent
    return np.broadcast_to(flags[:, None], (table.size, k)) if flags.ndim == 1 else flags


def _bounds(table: Table, column: Column, end: str) -> Array:
    """Bounds (size, *shape) of a parameter: those of its rows, else of the model."""
    own = table.bound(column.path, end)
    if own is None:
        return np.broadcast_to(of_model(column, end), (table.size, *column.shape))
    return own


def _agree(column: Column, a: Array, b: Array) -> bool:
    if column.kind != "real":
        return bool(np.array_equal(a, b))
    kind = kind_of(column)
    if kind == "quaternion":
        a, b = (rotations.matrix_from_quaternion(x.astype(np.float64)) for x in (a, b))
    elif kind == "euler":
        a, b = (rotations.matrix_from_euler(x.astype(np.float64)) for x in (a, b))
    scale = np.abs(a).max(initial=0.0) or 1.0
    tolerance = RELATIVE if a.dtype != np.float32 else 1e-6
    return bool(np.abs(a - b).max(initial=0.0) <= tolerance * scale)
