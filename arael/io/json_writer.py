"""JSON writer: the format of `json_reader`, one row of a collection per line."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from arael.io.json_reader import PRIORS
from arael.io.refs import refs_as_data
from arael.runtime.layout import Column
from arael.runtime.store import Store, Table
from arael.runtime.store.bounds import ENDS, of_model
from arael.runtime.store.messages import error
from arael.runtime.store.schema import Group, Leaf

encode = msgspec.json.encode


def dump(store: Store) -> bytes:
    """Return the data of a store as JSON.

    Raises
    ------
    AraelError
        E0705 where a number is NaN or infinite, E0709 for a stale ref, E0702 if the root lacks a
        value.
    """
    store.check_complete()
    root = _objects(store.root, store.root.fields)[0]
    if store.residuals is not None and store.residuals.priors:
        root[PRIORS] = store.model()._saved_priors()
    lines = []
    for name, value in root.items():
        if isinstance(value, list) and value and isinstance(value[0], dict):
            rows = b",\n    ".join(encode(row) for row in value)
            text = b"[\n    " + rows + b"\n  ]"
        else:
            text = encode(value)
        lines.append(b"  " + encode(name) + b": " + text)
    return b"{\n" + b",\n".join(lines) + b"\n}\n"


def _objects(table: Table, group: Group) -> list[dict[str, Any]]:
    """One object per row of a table for a struct of it (also where it is absent)."""
    objects: list[dict[str, Any]] = [{} for _ in range(table.size)]
    for name, member in group.members.items():
        if isinstance(member, Leaf):
            if member.column.role == "constraint_index":
                continue
            values = leaf_values(table, member)
        elif isinstance(member, Group):
            values = _objects(table, member)
            if member.refs:
                values = [list(one.values()) for one in values]
            if member.optional:
                there = table.column(f"{member.path}?").tolist()
                values = [v if t else None for v, t in zip(values, there, strict=True)]
        else:
            child = table.store.tables[member.table.path]
            held = _objects(child, child.fields)
            order, offsets = child.grouped()
            ordered = [held[i] for i in order.tolist()]
            bounds = offsets.tolist()
            values = [ordered[a:b] for a, b in pairwise(bounds)]
        for item, value in zip(objects, values, strict=True):
            item[name] = value
    return objects


def leaf_values(table: Table, leaf: Leaf) -> list[Any]:
    """Values of a field for JSON; None where absent."""
    column, path = leaf.column, leaf.path
    if column.role == "ref":
        return refs_as_data(table, column)
    array = table.column(path)
    there = table.present(path)
    if column.kind == "real":
        refuse_not_finite(table, leaf, array, there)
        array = shortest(array)
    values: list[Any] = array.tolist()
    if column.role == "param":
        parts = own_parts(table, column)
        if parts:
            values = [_with_parts(v, i, parts) for i, v in enumerate(values)]
    if leaf.optional:
        values = [v if t else None for v, t in zip(values, there.tolist(), strict=True)]
    return values


def own_parts(table: Table, column: Column) -> dict[str, dict[int, Any]]:
    """Flags and bounds of a parameter in rows that have their own, ``fixed``, ``low``, ``high``."""
    path = column.path
    found: dict[str, dict[int, Any]] = {}
    # What `optimize = False` excludes from solves is fixed in a file.
    fixed, some = table.fixed(path) | ~table.optimize(path), table.fixed_components(path)
    if fixed.any():
        found["fixed"] = dict.fromkeys(np.flatnonzero(fixed).tolist(), True)
    if some is not None and some.any():
        rows = np.flatnonzero(some.any(axis=1) & ~fixed).tolist()
        found.setdefault("fixed", {}).update((row, some[row].tolist()) for row in rows)
    for end in ENDS:
        own, differs = own_bounds(table, column, end)
        if differs.any():
            flat = own.astype(object)
            flat[np.isinf(own)] = None
            found[end] = {row: flat[row].tolist() if column.shape else flat[row]
                          for row in np.flatnonzero(differs).tolist()}  # fmt: skip
    return found


def own_bounds(table: Table, column: Column, end: str) -> tuple[NDArray[Any], NDArray[np.bool_]]:
    """Bounds (size, *shape), and rows (size,) where they are not those of the model.

    Raises AraelError: E0705 for a bound that is NaN.
    """
    own = table.bound(column.path, end)
    if own is None:
        return np.zeros(0), np.zeros(0, np.bool_)
    axes = tuple(range(1, own.ndim))
    bad = np.isnan(own).any(axis=axes)
    if bad.any():
        name = f"{table.name_of(int(np.argmax(bad)), column.path)}.{end}"
        raise error("E0705", f"cannot write: {name} is NaN", name, column)
    differs = own != of_model(column, end)
    return own, np.asarray(differs.any(axis=axes))


def fixed_flags(table: Table, column: Column) -> NDArray[np.bool_]:
    """Flags (size,) of what is held of a parameter, or (size, k) where components have theirs."""
    fixed = table.fixed(column.path) | ~table.optimize(column.path)
    some = table.fixed_components(column.path)
    return fixed if some is None or not some.any() else fixed[:, None] | some


def _with_parts(value: Any, row: int, parts: dict[str, dict[int, Any]]) -> Any:
    """The value of one row, with its flag and bounds if it has any."""
    own = {name: rows[row] for name, rows in parts.items() if row in rows}
    return {"value": value, **own} if own else value


def refuse_not_finite(
    table: Table, leaf: Leaf, array: NDArray[Any], there: NDArray[np.bool_]
) -> None:
    """Raise E0705 for the first number that is not finite."""
    bad = ~np.isfinite(array).all(axis=tuple(range(1, array.ndim))) & there
    if bad.any():
        name = table.name_of(int(np.argmax(bad)), leaf.path)
        raise error("E0705", f"cannot write: {name} is NaN or infinite", name, leaf.column)


def shortest(array: NDArray[Any]) -> NDArray[np.float64]:
    """Doubles whose shortest text is that of the single-precision number they came from."""
    if array.dtype != np.float32:
        return array
    return array.astype(np.str_).astype(np.float64)
