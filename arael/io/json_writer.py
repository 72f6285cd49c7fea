"""JSON writer: the format of `json_reader`, one row of a collection per line."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import msgspec
import numpy as np
from numpy.typing import NDArray

from arael.io.refs import refs_as_data
from arael.runtime.store import Store, Table
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
    if column.role == "param" and table.fixed(path).any():
        flags = table.fixed(path).tolist()
        values = [
            {"value": v, "fixed": True} if f else v for v, f in zip(values, flags, strict=True)
        ]
    if leaf.optional:
        values = [v if t else None for v, t in zip(values, there.tolist(), strict=True)]
    return values


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
