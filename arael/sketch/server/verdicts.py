"""What is free and what is redundant, for the colours of pages."""

from __future__ import annotations

from typing import Any

from arael.sketch.editing.editor import Editor


def verdict(editor: Editor, revision: int) -> dict[str, Any]:
    """The verdict on the whole sketch, as a message."""
    document = editor.document
    found = editor.judge.freedoms()
    entities = {name: "free" if count else "defined" for name, count in found.by_entity.items()}
    constraints: dict[str, str] = {}
    for name in found.redundant:
        constraints[name] = "redundant"
        record = document.constraints.get(name) or document.dimensions.get(name)
        for handle in record.args if record is not None else ():
            owner = handle.partition(".")[0]
            if entities.get(owner) == "defined":
                entities[owner] = "redundant"
    return {
        "type": "verdict",
        "revision": revision,
        "freedoms": found.total,
        "entities": entities,
        "constraints": constraints,
        "full": True,
    }
