"""Conversion of nested keyword arguments to columns by path for the store."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from arael.diagnostics.records import AraelError
from arael.face.parameter import Parameter
from arael.runtime.store import Handles
from arael.runtime.store.bounds import ENDS
from arael.runtime.store.messages import Origin, below, describe, error, unknown_field
from arael.runtime.store.schema import Group, Leaf, Nested


def flatten(
    group: Group, values: Any, origin: Origin
) -> tuple[dict[str, Any], list[tuple[Nested, Any]]]:
    """Values of a struct by path, and the values of its collections.

    Keys are names or dotted paths; a struct takes a dict (or None where optional), a parameter its
    value or ``{"value": ..., "fixed": True, "low": 0, "high": None}``, a list of refs its refs.
    """
    flat: dict[str, Any] = {}
    children: list[tuple[Nested, Any]] = []
    if group.refs and not isinstance(values, Mapping):
        # imported here: the circle of fields, collections and refs
        from arael.face.ref_list import elements

        values = elements(values, group.refs, origin, group.struct)
    if not isinstance(values, Mapping):
        raise error("E0703", f"expected a dict of fields, found {describe(values)}", origin)
    for key, value in values.items():
        member = group.find(key)
        bare = key
        if member is None:
            bare = bare_path(key)
            member = group.find(bare)
        if member is None:
            raise AraelError(unknown_field(key, group.members, group.struct, group.where, origin))
        path = f"{group.path}.{key}" if group.path else key
        if bare != key:
            flat[path] = value
        elif isinstance(member, Nested):
            children.append((member, value))
        elif isinstance(member, Leaf):
            _leaf(flat, member, value)
        elif value is None or (member.optional and _is_presence(value)):
            flat[f"{path}?"] = False if value is None else _presence(value, below(origin, key))
        else:
            inner, held = flatten(member, value, below(origin, key))
            if member.optional:
                flat.setdefault(f"{path}?", True)
            flat.update(inner)
            children += held
    return flat, children


def _is_presence(value: Any) -> bool:
    if isinstance(value, (list, tuple)):
        return not value or any(isinstance(item, (bool, np.bool_)) for item in value)
    return isinstance(value, (bool, np.bool_, np.ndarray))


def _presence(value: Any, origin: Origin) -> Any:
    """Presence of an optional struct: the value, or an array of bools for a list."""
    if not isinstance(value, (list, tuple)):
        return value
    for row, item in enumerate(value):
        if not isinstance(item, (bool, np.bool_)):
            raise error(
                "E0703",
                f"expected true or false for each row, found {describe(item)} in row {row}",
                origin,
            )
    return np.array(value, np.bool_)


def _leaf(flat: dict[str, Any], leaf: Leaf, value: Any) -> None:
    if leaf.column.role == "ref":
        flat[leaf.path] = refs(value)
    elif leaf.column.role == "param" and isinstance(value, Mapping):
        flat.update(parts_of(leaf, value, leaf.path))
    else:
        flat[leaf.path] = np.array(value.value) if isinstance(value, Parameter) else value


def bare_path(path: str) -> str:
    """Path of the field whose presence, flag or bounds `path` is."""
    bare = path.removesuffix("?")
    for part in (".fixed", *(f".{end}" for end in ENDS)):
        bare = bare.removesuffix(part)
    return bare


def parts_of(leaf: Leaf, given: Mapping[str, Any], origin: Origin) -> dict[str, Any]:
    """Value, flag and bounds of a parameter given as a dict, by path; `fixed` is false if left out.

    Raises AraelError: E0703 for other keys, or without a value.
    """
    if not given.keys() <= {"value", "fixed", *ENDS} or "value" not in given:
        raise error(
            "E0703",
            'expected a value or {"value": ..., "fixed": ..., "low": ..., "high": ...}',
            origin,
            leaf.column,
        )
    found = {leaf.path: given["value"], f"{leaf.path}.fixed": given.get("fixed", False)}
    return found | {f"{leaf.path}.{end}": given[end] for end in ENDS if end in given}


def refs(value: Any) -> Any:
    """Convert refs in any form for the store: `Handles`, or indices; other values unchanged."""
    # imported here: the circle of fields, collections and refs
    # imported here: start-up time
    from arael.face.ref import Ref, Refs

    if isinstance(value, Ref):
        return Handles(value._table, np.array(value._handle, np.int64))
    if isinstance(value, Refs):
        return Handles(value._table, value._handles)
    if isinstance(value, (list, tuple)) and any(isinstance(v, Ref) for v in value):
        first = next(v for v in value if isinstance(v, Ref))
        handles = []
        for item in value:
            if item is None:
                handles.append(-1)
            elif isinstance(item, Ref) and item._table is first._table:
                handles.append(item._handle)
            elif not isinstance(item, Ref):
                raise error(
                    "E0703",
                    f"expected a ref in every row, found {describe(item)}",
                    first._table.label,
                    help="give refs for all rows, or indices or keys for all",
                )
            else:
                raise error(
                    "E0710", "the refs do not all point into one collection", first._table.label
                )
        return Handles(first._table, np.array(handles, np.int64))
    return value
