"""`lock` and `unlock`."""

from __future__ import annotations

from arael.sketch.commands.creating import placed_at
from arael.sketch.commands.numbers import place
from arael.sketch.commands.reading import Operand, Words
from arael.sketch.commands.replies import Reply
from arael.sketch.commands.session import Session
from arael.sketch.commands.table import command
from arael.sketch.commands.tokens import fail
from arael.sketch.document.records import Constraint


@command(
    "lock",
    group="modify",
    usage=("lock P0", "lock L0.p1 [L0.p2 ...]", "lock L0.p1 x,y"),
    summary="Hold a point where it is, or at a place.",
    details="A lock takes two degrees of freedom. A point that is locked already is locked anew.",
    arguments=("*points",),
)
def lock(session: Session, words: Words) -> Reply:
    """Hold points."""
    points = [words.operand("a point", "point")]
    while words and (token := words.peek()) is not None and words.find(token) is not None:
        points.append(words.operand("a point", "point"))
    at = words.point("where") if words and len(points) == 1 else None
    words.end()
    said = []
    with placed_at(words):
        for point in points:
            offset = session.document.point_at(point.handle)
            x, y = session.document.values[offset : offset + 2].tolist()
            numbers = (at.x, at.y) if at is not None else (x, y)
            known = _lock_of(session, point)
            if known is not None:
                made = session.editor.change_constraint(known.name, numbers=numbers)
            else:
                made = session.editor.constrain("lock", (point.handle,), numbers=numbers)
            said.append(f"Locked {point.handle} at {place(*numbers)} ({made.name})")
    return Reply("\n".join(said), remembered=False)


@command(
    "unlock",
    group="modify",
    usage=("unlock P0", "unlock L0.p1 [L0.p2 ...]"),
    summary="Let a locked point go.",
    arguments=("*points",),
)
def unlock(session: Session, words: Words) -> Reply:
    """Remove locks."""
    points = words.operands("a point", "point")
    words.end()
    said = []
    for point in points:
        known = _lock_of(session, point)
        if known is None:
            fail("E1268", f"`{point.handle}` is not locked", point.token.span)
        session.editor.delete([known.name])
        said.append(f"Unlocked {point.handle}")
    return Reply("\n".join(said), remembered=False)


def _lock_of(session: Session, point: Operand) -> Constraint | None:
    layout, constraints = session.editor.layout, session.document.constraints
    layout.refresh()
    users = (constraints.get(name) for name in layout.users_of(point.handle))
    return next(
        (one for one in users if one and one.kind == "lock" and one.args == (point.handle,)), None
    )
