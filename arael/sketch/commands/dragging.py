"""`drag`: points and bodies, as far as the constraints let them."""

from __future__ import annotations

import math

from arael.sketch.commands.creating import placed_at
from arael.sketch.commands.describing import entity_line, points_of
from arael.sketch.commands.numbers import listed, place
from arael.sketch.commands.reading import Operand, Words
from arael.sketch.commands.replies import Reply
from arael.sketch.commands.session import Session
from arael.sketch.commands.table import command
from arael.sketch.document.document import Document
from arael.sketch.expressions.vectors import Vec


@command(
    "drag",
    group="modify",
    usage=("drag L0.p1 x,y", "drag L0.p2 @dx,dy", "drag L0 @dx,dy", "drag A0.center x,y"),
    summary="Pull a point or a whole entity; the rest of the sketch follows.",
    details="""
`@dx,dy` is relative to where it is. A whole line is pulled by its middle, arcs and ellipses by
their centre, splines by their first pole; its shape stays as far as it can. Constraints stay exact:
what cannot reach the place stops as near to it as they let it, which is said.
""",
    arguments=("operand", "to"),
)
def drag(session: Session, words: Words) -> Reply:
    """Pull something."""
    document = session.document
    found = words.operand()
    handles = _handles(found)
    grip = _grip(document, found)
    words.origin = grip
    to = words.point("where to")
    words.end()
    shift = to.at - grip
    moves = {}
    for handle in handles:
        at = _at(document, handle)
        moves[handle] = (at.x + shift.x, at.y + shift.y)
    with placed_at(words):
        outcome = session.editor.drag(moves)
    now = _grip(document, found)
    missed = math.hypot(now.x - to.x, now.y - to.y)
    size = max(math.hypot(shift.x, shift.y), abs(to.x), abs(to.y))
    reached = missed <= 1e-7 * size
    text = f"Dragged {found.handle} to {place(now.x, now.y)}"
    if not reached:
        text += f", not to {place(to.x, to.y)}: the constraints hold it"
    if not found.point:
        text += f"\n  {entity_line(document, document.entities[found.entity.name])}"
    moved = [name for name in outcome.moved if name != found.entity.name]
    text += f"\n  moved too: {listed(moved, 12)}" if moved else ""
    data = {"at": [now.x, now.y], "reached": reached, "moved": list(outcome.moved)}
    return Reply(text, remembered=False, data=data)


def _handles(found: Operand) -> list[str]:
    if found.point or found.entity.kind == "point":
        return [found.handle]
    handles = points_of(found.entity)
    if found.entity.kind in ("bezier", "bspline"):
        return [one for one in handles if ".pole" in one]
    return handles


def _at(document: Document, handle: str) -> Vec:
    at = document.point_at(handle)
    x, y = document.values[at : at + 2].tolist()
    return Vec(x, y)


def _grip(document: Document, found: Operand) -> Vec:
    """Where something is pulled."""
    if found.point or found.entity.kind == "point":
        return _at(document, found.handle)
    if found.entity.kind == "line":
        x1, y1, x2, y2 = document.numbers_of(found.entity.name).tolist()
        return Vec(0.5 * (x1 + x2), 0.5 * (y1 + y2))
    x, y = document.numbers_of(found.entity.name).tolist()[:2]
    return Vec(x, y)
