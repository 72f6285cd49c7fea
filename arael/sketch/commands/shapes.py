"""Shapes in one command: `add_slot`, `add_polygon`."""

from __future__ import annotations

import math
from collections.abc import Sequence

from arael.sketch.commands.creating import placed_at
from arael.sketch.commands.describing import entity_line
from arael.sketch.commands.numbers import shown
from arael.sketch.commands.reading import Words
from arael.sketch.commands.replies import Reply
from arael.sketch.commands.session import Session
from arael.sketch.commands.table import command
from arael.sketch.commands.tokens import fail
from arael.sketch.document.records import Group, Option
from arael.sketch.groups.copies import names_of, owned_since


def _add(session: Session, words: Words, kind: str, numbers: Sequence[float]) -> str:
    made = session.editor.add(
        kind,
        numbers,
        connect=False,
        construction="constr" in words.flags,
        quiet="quiet" in words.flags,
    )
    return made.entity.name


def _grouped(
    session: Session, kind: str, names: Sequence[str], before: set[str], **options: Option
) -> Group:
    document = session.document
    owned = owned_since(document, before)
    return document.put(
        "groups",
        Group(document.next_name("M"), kind, results=tuple(names), owned=owned, options=options),
    )


def _reply(session: Session, group: Group, text: str) -> Reply:
    lines = [entity_line(session.document, session.document.entities[n]) for n in group.results]
    return Reply(
        "\n".join([f"Added {group.name}: {text}", *(f"  {line}" for line in lines)]),
        group.results,
        group.name,
        data={"group": group.name, "entities": list(group.results), "owned": list(group.owned)},
    )


@command(
    "add_polygon",
    group="create",
    usage=("add_polygon N cx,cy px,py [corner] [flat] [quiet] [constr]",),
    summary="A regular polygon of N sides about a centre.",
    details="""
The last coordinate is a corner, with `flat` the middle of a side. The corners lie on a construction
circle, and the sides are equal: four freedoms are left, place, size and direction. `_` is the
group, `_0`, ... are the sides, the last one is the circle.

```
hexagon = add_polygon 6 0,0 5,0
```
""",
    keywords=("corner", "flat", "quiet", "constr"),
    arguments=("count", "center", "at"),
)
def add_polygon(session: Session, words: Words) -> Reply:
    """A regular polygon."""
    words.refuse_together("corner", "flat")
    count = words.whole("the number of sides", 3, 1000)
    center, corner = words.point("the centre"), words.point("a corner")
    words.end()
    radius = math.dist((center.x, center.y), (corner.x, corner.y))
    if not radius > 0.0:
        fail("E1220", "the corner of a polygon is away from its centre", corner.token.span)
    angle = math.atan2(corner.y - center.y, corner.x - center.x)
    if "flat" in words.flags:
        angle -= math.pi / count
        radius /= math.cos(math.pi / count)
    places = [
        (
            center.x + radius * math.cos(angle + 2.0 * math.pi * i / count),
            center.y + radius * math.sin(angle + 2.0 * math.pi * i / count),
        )
        for i in range(count)
    ]
    editor = session.editor
    before = names_of(session.document)
    with placed_at(words), editor.together():
        sides = [
            _add(session, words, "line", (*places[i], *places[(i + 1) % count]))
            for i in range(count)
        ]
        circle = editor.add(
            "circle", (center.x, center.y, radius), connect=False, construction=True, quiet=True
        ).entity.name
        for i, side in enumerate(sides):
            editor.constrain("coincident", (f"{side}.p2", f"{sides[(i + 1) % count]}.p1"))
            editor.constrain("point_on", (f"{side}.p1", circle))
        for side in sides[1:]:
            editor.constrain("equal", (sides[0], side))
    group = _grouped(session, "polygon", [*sides, circle], before, count=count)
    return _reply(session, group, f"polygon of {count} sides, radius {shown(radius)}")


@command(
    "add_slot",
    group="create",
    usage=("add_slot x1,y1 x2,y2 RADIUS [quiet] [constr]",),
    summary="A slot: two parallel lines and two half circles about two centres.",
    details="""
Five freedoms are left: both centres and the radius. `_` is the group, `_0` and `_1` are the lines,
`_2` and `_3` the half circles about the second and the first centre.

```
s = add_slot 0,0 10,0 2
```
""",
    keywords=("quiet", "constr"),
    arguments=("first", "second", "radius"),
)
def add_slot(session: Session, words: Words) -> Reply:
    """A slot."""
    first, second = words.point("a centre"), words.point("the other centre")
    radius = words.number("the radius", "length", above=0.0)
    words.end()
    length = math.dist((first.x, first.y), (second.x, second.y))
    if not length > 0.0:
        fail("E1220", "the centres of a slot are apart", second.token.span)
    u = -(second.y - first.y) / length * radius, (second.x - first.x) / length * radius
    a, b = (first.x, first.y), (second.x, second.y)
    corners = [(p[0] + k * u[0], p[1] + k * u[1]) for p, k in ((a, -1), (b, -1), (b, 1), (a, 1))]
    editor = session.editor
    before = names_of(session.document)
    with placed_at(words), editor.together():
        low = _add(session, words, "line", (*corners[0], *corners[1]))
        high = _add(session, words, "line", (*corners[2], *corners[3]))
        right = _add(session, words, "arc", (*b, *corners[1], *corners[2], radius))
        left = _add(session, words, "arc", (*a, *corners[3], *corners[0], radius))
        for args in (
            (f"{low}.p2", f"{right}.start"),
            (f"{right}.end", f"{high}.p1"),
            (f"{high}.p2", f"{left}.start"),
            (f"{left}.end", f"{low}.p1"),
        ):
            editor.constrain("coincident", args)
        for line, arc in ((low, right), (high, right), (high, left), (low, left)):
            editor.constrain("tangent", (line, arc))
        editor.constrain("equal", (right, left))
    group = _grouped(session, "slot", (low, high, right, left), before, radius=radius)
    return _reply(session, group, f"slot of radius {shown(radius)}, {shown(length)} long")
