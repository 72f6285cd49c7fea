"""``.value`` of a formula: what it was when the solve began."""

from __future__ import annotations

from dataclasses import replace

from arael.check.binding import BROKEN, Broken
from arael.check.typed import Apply, Component, Pack, Read, Select, Typed
from arael.check.typist import Typist
from arael.check.walk import postorder


def as_stored(t: Typist, value: Typed) -> Typed | Broken:
    """`value` over the stored values of all that it reads.

    A ``compute`` field has none: what it was computed from is kept, it is not.
    """
    done: dict[int, Typed] = {}
    for node in postorder([value]):
        copy = _copy(node, done)
        if copy is None:
            return t.fail(
                "E0308",
                node.span,
                "a `compute` field has no stored value",
                label="its stored value is asked for",
                help=["write it as `symbolic`"],
            )
        if isinstance(node, Read):
            t.units.read(copy, t.units.fields.get(id(node)))
        if copy is not node and isinstance(t.make(copy), Broken):
            return BROKEN
        done[id(node)] = copy
    return done[id(value)]


def _copy(node: Typed, done: dict[int, Typed]) -> Typed | None:
    match node:
        case Read(version="computed"):
            return None
        case Read(version="trial"):
            return replace(node, version="stored")
        case Apply():
            return replace(node, args=tuple(done[id(a)] for a in node.args))
        case Component():
            return replace(node, of=done[id(node.of)])
        case Pack():
            return replace(node, items=tuple(done[id(i)] for i in node.items))
        case Select():
            parts = (done[id(p)] for p in (node.cond, node.then, node.otherwise))
            return replace(node, **dict(zip(("cond", "then", "otherwise"), parts, strict=True)))
        case _:
            return node
