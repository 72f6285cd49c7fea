"""Models and collections as tables for notebooks and terminals."""

from __future__ import annotations

from typing import Any

import numpy as np

from arael.display.sheet import Sheet
from arael.runtime.store.schema import Group, Leaf, Nested

MOST_ROWS = 10
"""Rows of a collection that are shown; of more the first and the last few."""
LAST_ROWS = 3


def model_sheet(model: Any, title: str) -> Sheet:
    """The fields of a model's root with their types and values."""
    rows = []
    for name, member in model._group.members.items():
        if isinstance(member, Nested):
            kind = f"{member.table.collection} of {member.table.struct}"
            rows.append((name, kind, f"{len(model._get(member))} rows"))
        elif isinstance(member, Leaf):
            column = member.column
            param = "param " if column.role == "param" else ""
            rows.append((name, f"{param}{column.type}", _value(model, member)))
        else:
            kind = f"[ref {member.struct}; {member.refs}]" if member.refs else member.struct
            rows.append((name, kind, _value(model, member)))
    return Sheet(title, ("field", "type", "value"), rows)


def collection_sheet(collection: Any) -> Sheet:
    """The first and the last rows of a collection."""
    members = [
        (name, member)
        for name, member in collection._group.members.items()
        if not (isinstance(member, Leaf) and member.column.role == "constraint_index")
    ]
    count = len(collection)
    cut = count > MOST_ROWS
    first = MOST_ROWS - LAST_ROWS if cut else count
    rows = [_row(collection[k], members) for k in range(first)]
    if cut:
        rows.append(["...", *[""] * len(members)])
        rows += [_row(collection[k], members) for k in range(count - LAST_ROWS, count)]
    head = ("row", *(name for name, _ in members))
    return Sheet(repr(collection).strip("<>"), head, rows)


def _row(ref: Any, members: list[tuple[str, Group | Leaf | Nested]]) -> list[str]:
    return [str(ref._rows()), *(_value(ref, member) for _, member in members)]


def _value(fields: Any, member: Group | Leaf | Nested) -> str:
    if isinstance(member, Leaf) and member.path in fields._table.missing:
        return "not set"
    unset = fields._table.missing
    if isinstance(member, Group) and member.refs and any(x.path in unset for x in member.leaves()):
        return "not set"
    text: str = fields.short_text(member)
    if isinstance(member, Leaf) and member.column.role == "param":
        parameter = fields._get(member)
        if parameter is not None and np.all(parameter.fixed):
            return f"{text} (fixed)"
    return text
