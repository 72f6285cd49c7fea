"""`scale`, `rotate` and `move`: entities as one, with what is measured inside of them."""

from __future__ import annotations

import math

from arael.sketch.commands.creating import placed_at
from arael.sketch.commands.describing import dimension_line
from arael.sketch.commands.numbers import place, shown
from arael.sketch.commands.reading import Words
from arael.sketch.commands.replies import Reply
from arael.sketch.commands.session import Session
from arael.sketch.commands.table import command
from arael.sketch.commands.tokens import fail
from arael.sketch.expressions.vectors import Vec
from arael.sketch.transfer.similar import Followed, Similarity, mapped


@command(
    "scale",
    group="modify",
    usage=("scale L0 A0 ... about P0 FACTOR", "scale selection about x,y FACTOR"),
    summary="Scale entities uniformly about a point.",
    details="""
Locks of scaled points follow. Lengths, distances and radii inside of the scaled set are multiplied,
literal bounds of ranges too. What cannot follow is left as it is and listed: expressions, and
dimensions to geometry that is not scaled.

```
scale L0 L1 about P0 2
```
""",
    arguments=("*words",),
)
def scale(session: Session, words: Words) -> Reply:
    """Scale entities."""
    names = _entities(words, "about")
    center = words.point("the centre")
    factor = words.number("the factor", above=0.0)
    words.end()
    by = Similarity((center.x, center.y), factor)
    text = f"Scaled {' '.join(names)} by {shown(factor)} about {place(center.x, center.y)}"
    return _mapped(session, words, names, by, text, "scaled")


@command(
    "rotate",
    group="modify",
    usage=("rotate L0 A0 ... about P0 ANGLE", "rotate selection about x,y ANGLE"),
    summary="Turn entities about a point, counter-clockwise in degrees.",
    details="""
Locks and angles from the x axis follow. By quarter turns `horizontal` and `vertical`, and distances
along the axes, are exchanged; by other angles such lines are made parallel and perpendicular to one
another in place of that, and distances along the axes only measure.
""",
    arguments=("*words",),
)
def rotate(session: Session, words: Words) -> Reply:
    """Turn entities."""
    names = _entities(words, "about")
    center = words.point("the centre")
    degrees = words.number("the angle", "angle")
    words.end()
    by = Similarity((center.x, center.y), turn=math.radians(math.remainder(degrees, 360.0)))
    text = f"Rotated {' '.join(names)} by {shown(degrees)} deg about {place(center.x, center.y)}"
    return _mapped(session, words, names, by, text, "turned")


@command(
    "move",
    group="modify",
    usage=("move L0 A0 ... @dx,dy", "move L0 ... from P0 to x,y", "move selection @dx,dy"),
    summary="Shift entities.",
    details="""
Locks of shifted points follow. Constraints and dimensions to the rest of the sketch stay, and are
solved: they may pull the geometry somewhere else.
""",
    arguments=("*words",),
)
def move(session: Session, words: Words) -> Reply:
    """Shift entities."""
    names = _entities(words, "from", "@")
    if not words.accept("from"):
        words.origin = Vec(0.0, 0.0)
        by = words.point("`@dx,dy`, or `from` and `to`")
        shift = (by.x, by.y)
    else:
        start = words.point("where from")
        words.choice("`to`", "to")
        end = words.point("where to")
        shift = (end.x - start.x, end.y - start.y)
    words.end()
    text = f"Moved {' '.join(names)} by {place(*shift)}"
    return _mapped(session, words, names, Similarity(shift=shift), text, "moved")


def _entities(words: Words, *ends: str) -> list[str]:
    """Take entities up to one of the words, of which `about` is taken too."""
    found: list[str] = []
    while words and not (words.items[0].text in ends or words.items[0].text[:1] in ends):
        if words.items[0].text == "selection":
            selected = words.selected()
            found += [one.entity.name for one in selected if not one.point]
            if not found:
                hint = "`select L0` selects a line"
                fail("E1259", "no entity is selected", selected[0].token.span, "", hint)
            continue
        found.append(words.operand("an entity", "entity").handle)
    if not found:
        words.missing("entities")
    if "about" in ends:
        words.choice("`about`", "about")
    elif not words:
        words.missing("`@dx,dy`, or `from` and `to`")
    return list(dict.fromkeys(found))


def _mapped(
    session: Session, words: Words, names: list[str], by: Similarity, text: str, verb: str
) -> Reply:
    with session.document.transaction(words.statement.text), placed_at(words):
        followed: Followed = mapped(session.editor, names, by)
    lines = [text]
    document = session.document
    if followed.changed:
        dims = "; ".join(dimension_line(session, document.dimensions[n]) for n in followed.changed)
        lines.append(f"  dims {verb}: {dims}")
    if followed.left:
        reasons = "; ".join(f"{name} ({reason})" for name, reason in followed.left.items())
        lines.append(f"  dims left: {reasons}")
    if followed.freed:
        lines.append(f"  dropped: {', '.join(followed.freed)} (not along the axes any more)")
    if followed.added:
        lines.append(f"  added: {', '.join(followed.added)}")
    return Reply(
        "\n".join(lines),
        remembered=False,
        data={
            "entities": names,
            "dims_changed": followed.changed,
            "dims_left": followed.left,
            "dropped": followed.freed,
            "added": followed.added,
        },
    )
