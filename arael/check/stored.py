"""``.value`` of a formula: its value at the start of the solve."""

from __future__ import annotations

from dataclasses import replace

from arael.check.binding import BROKEN, Broken
from arael.check.typed import Apply, Component, Formula, Invoke, Pack, Read, Select, Typed
from arael.check.typist import Typist
from arael.check.walk import operands, postorder


def as_stored(t: Typist, value: Formula) -> Typed | Broken:
    """`value` with all reads replaced by stored values.

    A ``compute`` field has none: its inputs are stored, its value is not.
    """
    done: dict[Typed, Typed] = {}
    for node in postorder([value]):
        if isinstance(node, Read) and node.version == "computed":
            return t.fail(
                "E0308",
                node.span,
                "a `compute` field has no stored value",
                label="its stored value is read",
                help=["declare it as `symbolic`"],
            )
        if isinstance(node, Formula):
            done[node] = done[node.of]
            continue
        copy = _copy(node, [done[part] for part in operands(node)])
        if isinstance(node, Read):
            t.units.read(copy, t.units.fields.get(node))
            if node in t.origins:
                t.origins[copy] = t.origins[node]
        if copy is not node and isinstance(t.make(copy), Broken):
            return BROKEN
        done[node] = copy
    return done[value]


def _copy(node: Typed, parts: list[Typed]) -> Typed:
    """`node` with other operands."""
    match node:
        case Read(version="trial"):
            return replace(node, version="stored")
        case Apply():
            return replace(node, args=tuple(parts))
        case Invoke():
            value = parts.pop() if node.value is not None else None
            return replace(node, args=tuple(parts), value=value)
        case Component():
            return replace(node, of=parts[0])
        case Pack():
            return replace(node, items=tuple(parts))
        case Select():
            return replace(node, cond=parts[0], then=parts[1], otherwise=parts[2])
        case _:
            return node
