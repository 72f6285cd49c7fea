"""Random data for any model: every field that its layout has, as a JSON value."""

from __future__ import annotations

import math
import random
from typing import Any

from arael.runtime.layout import Column, Layout
from arael.runtime.store.schema import Group, Leaf, fields_of

ROWS = 2
"""Rows of each collection of each owner; so a ref may be 0 or 1 wherever it points."""


def scene(layout: Layout, rng: random.Random) -> dict[str, Any]:
    """Data of a whole model."""
    return _row(layout, fields_of(layout, layout.tables[0]), rng)


def _row(layout: Layout, group: Group, rng: random.Random) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, member in group.members.items():
        if isinstance(member, Leaf):
            if (
                member.column.role in ("skip", "constraint_index")
                or member.column.type == "carried"
            ):
                continue
            if member.optional and rng.random() < 0.4:
                continue
            if member.column.default is not None and rng.random() < 0.5:
                continue
            found[name] = _value(member.column, rng)
        elif isinstance(member, Group):
            if not member.optional or rng.random() < 0.6:
                found[name] = _row(layout, member, rng)
        else:
            inner = fields_of(layout, member.table)
            found[name] = [_row(layout, inner, rng) for _ in range(ROWS)]
    return found


def _value(column: Column, rng: random.Random) -> Any:
    if column.role == "ref":
        return rng.randrange(ROWS)
    if column.kind == "string":
        return rng.choice(["a", "b", "é", ""]) + str(rng.randrange(10**6))
    if column.kind == "bool":
        return rng.random() < 0.7
    if column.kind == "int":
        return rng.randrange(5)
    param = column.param
    kind = param.kind if param is not None else column.type.split(" ")[0].rstrip("?")
    numbers = [round(rng.gauss(0, 1), 3) for _ in range(math.prod(column.shape))]
    if kind in ("rotation", "quaternion", "quat", "direction"):
        return _unit(numbers)
    if kind in ("transform", "similarity"):
        return [*numbers[:3], *_unit(numbers[3:7]), *(abs(x) + 0.5 for x in numbers[7:])]
    if param is not None and param.low:
        ends = zip(numbers, param.low, param.high, strict=True)
        numbers = [
            min(max(x, -math.inf if a is None else a), math.inf if b is None else b)
            for x, a, b in ends
        ]
    return _shaped(numbers, column.shape)


def _unit(numbers: list[float]) -> list[float]:
    length = math.hypot(*numbers)
    return [x / length for x in numbers] if length > 1e-3 else [1.0, *(0.0 for _ in numbers[1:])]


def _shaped(numbers: list[float], shape: tuple[int, ...]) -> Any:
    if not shape:
        return numbers[0]
    if len(shape) == 1:
        return numbers
    size = len(numbers) // shape[0]
    return [_shaped(numbers[i : i + size], shape[1:]) for i in range(0, len(numbers), size)]
