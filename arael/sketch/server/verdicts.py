"""What is free, redundant, impossible, for the colours of pages."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from arael.sketch.document.handles import point_offsets
from arael.sketch.editing.editor import Editor
from arael.sketch.judge.judge import Freedoms


def verdict(editor: Editor, revision: int) -> dict[str, Any]:
    """The verdict on the whole sketch, as a message."""
    found = editor.judge.freedoms()
    constraints = {one.name: one.kind for one in editor.judge.standing(found.redundant)}
    entities = {name: "free" if count else "defined" for name, count in found.by_entity.items()}
    points = _points(editor, found)
    _mark(editor, constraints, entities)
    return {
        "type": "verdict",
        "revision": revision,
        "freedoms": found.total,
        "entities": entities,
        "constraints": constraints,
        "points": points,
        "full": True,
    }


def _points(editor: Editor, found: Freedoms) -> dict[str, str]:
    """Points that are defined of entities that are not, by handle."""
    return {
        f"{entity.name}.{point}": "defined"
        for entity in editor.document.entities.values()
        if found.by_entity[entity.name] and entity.kind != "point"
        for point, at in point_offsets(entity).items()
        if not found.moves[at : at + 2].any()
    }


def _mark(editor: Editor, constraints: Mapping[str, str], entities: dict[str, str]) -> None:
    """Entities show what is wrong with a constraint on them; impossible before redundant."""
    document = editor.document
    for name, standing in constraints.items():
        record = document.find(name)
        for handle in getattr(record, "args", ()):
            owner = handle.partition(".")[0]
            if standing == "impossible" and owner in entities:
                entities[owner] = "impossible"
            elif standing == "redundant" and entities.get(owner) == "defined":
                entities[owner] = "redundant"
