"""The sketch in words, for agents."""

from __future__ import annotations

from typing import Any

from arael.sketch.commands.describing import record_line
from arael.sketch.server.shared import SharedSketch

MAX_RECORDS = 2000
"""Records of a table that are described; the JSON resource has all."""

MAX_MOTIONS = 400
"""Degrees of freedom up to which each is described."""


def state_of(shared: SharedSketch) -> dict[str, Any]:
    """Everything in the sketch in lines of text, what is still free, what is redundant."""
    session = shared.session
    document = session.document
    freedoms = session.editor.judge.freedoms()
    found: dict[str, Any] = {
        "file": shared.keeper.path.name if shared.keeper else "",
        "unit": document.unit,
        "revision": shared.revision,
        "degrees_of_freedom": freedoms.total,
    }
    if 0 < freedoms.total <= MAX_MOTIONS:
        found["free"] = [motion.sentence for motion in session.editor.judge.free()]
    if freedoms.redundant:
        found["redundant"] = list(freedoms.redundant)
    for table in ("entities", "constraints", "dimensions", "parameters", "groups"):
        records = list(getattr(document, table).values())
        found[table] = [record_line(session, one) for one in records[:MAX_RECORDS]]
        if len(records) > MAX_RECORDS:
            found[f"{table}_left_out"] = len(records) - MAX_RECORDS
    return found
