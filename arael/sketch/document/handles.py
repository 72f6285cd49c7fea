"""Handles: the texts by which commands, constraints and files name things of a sketch."""

from __future__ import annotations

import re
from typing import NamedTuple

from arael.sketch.document.kinds import ENTITIES, OPERANDS, PREFIXES
from arael.sketch.document.records import Entity

_HANDLE = re.compile(r"([A-Za-z]+\d+)(?:\.(\w+))?\Z")
#: Letters and a number, but for `p1` and `pole3`, which are points of entities.
_NAME = re.compile(r"(?!p\d|pole\d)([A-Za-z]+)[0-9]+\Z")

#: Longest name of a record, in characters.
LONGEST_NAME = 40


class Handle(NamedTuple):
    """An entity, or one of its points.

    Attributes
    ----------
    name : of the entity
    point : of the point; empty for the entity itself
    """

    name: str
    point: str


def split_handle(text: str) -> Handle | None:
    """The parts of a handle as it is written, None if the text is none."""
    found = _HANDLE.match(text)
    return Handle(found[1], found[2] or "") if found else None


def can_name(name: str, prefix: str) -> bool:
    """Whether an entity or dimension can have a name: letters and a number, ``bore1``.

    Parameters
    ----------
    prefix : of its kind; those of other kinds are not free
    """
    found = _NAME.match(name)
    if found is None or len(name) > LONGEST_NAME:
        return False
    return found[1] == prefix or found[1] not in PREFIXES


def point_offsets(entity: Entity) -> dict[str, int]:
    """Offset in ``document.values`` of the x of every named point of an entity.

    The numbers of an arc run counter-clockwise; one that was drawn clockwise starts at their end.
    """
    kind = ENTITIES[entity.kind]
    if not kind.poles:
        found = {name: entity.at + offset for name, offset in kind.points}
        if entity.clockwise:
            found["start"], found["end"] = found["end"], found["start"]
        return found
    count = entity.size // 2
    offsets = {f"pole{i + 1}": entity.at + 2 * i for i in range(count)}
    return {"p1": entity.at, "p2": entity.at + 2 * (count - 1), **offsets}


def ends(entity: Entity) -> tuple[str, ...]:
    """Names of the points where a curve begins and ends; empty for points and closed curves."""
    if entity.kind in ("line", "bezier", "bspline"):
        return ("p1", "p2")
    return ("start", "end") if entity.kind in ("arc", "earc") else ()


def takes(operand: str, entity: Entity, point: str) -> bool:
    """Whether an operand's class takes an entity (`point` empty) or one of its points.

    A point entity is a point.
    """
    if operand == "point":
        return bool(point) or entity.kind == "point"
    if operand == "end":
        return point in ends(entity)
    return not point and entity.kind in OPERANDS[operand.removesuffix("*")]
