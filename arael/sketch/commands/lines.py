"""Points and lines: `add_point`, `add_line`, rectangles."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from arael.diagnostics.records import AraelError
from arael.sketch.commands import creating
from arael.sketch.commands.numbers import place
from arael.sketch.commands.reading import Words, placed
from arael.sketch.commands.replies import Reply
from arael.sketch.commands.session import Session
from arael.sketch.commands.table import command
from arael.sketch.commands.tokens import fail
from arael.sketch.document.records import Entity
from arael.sketch.editing.results import Added
from arael.sketch.expressions.vectors import Vec


@command(
    "add_point",
    group="create",
    usage=("add_point x,y [noconnect] [nocursor] [quiet] [constr]",),
    summary="A point.",
    keywords=creating.COMMON,
    arguments=("at",),
)
def add_point(session: Session, words: Words) -> Reply:
    """A point."""
    at = words.point()
    words.end()
    added = creating.add(session, words, "point", (at.x, at.y))
    creating.leave_cursor(session, words, added.entity, "pos")
    return creating.reply(f"{added.entity.name}: {place(at.x, at.y)}", [added])


@command(
    "add_line",
    group="create",
    usage=(
        "add_line x1,y1 x2,y2 [noconnect] [notangent] [nocursor] [driven] [quiet] [constr]",
        "add_line x1,y1 x2,y2 x3,y3 ...",
        "add_line x2,y2",
    ),
    summary="A line between two points, or a chain of lines through any number of them.",
    details="""
With one coordinate the line starts where the last line or arc ended. Ends within 1e-3 of another
point become coincident with it; `driven` adds a length at its present value to every line.

```
add_line 0,0 5,0
add_line @0,3              # goes on from the last end
a, b, c = add_line 0,0 @1,0 @0,1 @-1,0
```
""",
    keywords=(*creating.COMMON, "notangent", "driven"),
    arguments=("*points",),
)
def add_line(session: Session, words: Words) -> Reply:
    """A line, or a chain of lines."""
    if len(words) == 1:
        words.origin = session.state.chain or session.state.cursor or words.origin
    places = words.points(least=1)
    points = [one.at for one in places]
    if len(points) == 1:
        start = session.state.chain or session.state.cursor
        if start is None:
            message = "`add_line` with one coordinate goes on from the last line or arc"
            help_ = "there is none yet: give two coordinates"
            fail("E1259", message, places[0].token.span, "", help_)
        points.insert(0, start)
    added = [
        creating.add(session, words, "line", (a.x, a.y, b.x, b.y)) for a, b in pairwise(points)
    ]
    dimensions = creating.drive(session, words, *(("length", a.entity.name) for a in added))
    creating.leave_cursor(session, words, added[-1].entity, "p2")
    text = " ".join(
        creating.shown_line(one.entity.name, a, b)
        for one, (a, b) in zip(added, pairwise(points), strict=True)
    )
    return creating.reply(text, added, dimensions)


_RECTANGLE = ("noconnect", "noconstraint", "hv", "driven", "strict", "quiet", "constr", "nocursor")


@command(
    "add_rect",
    group="create",
    usage=("add_rect x1,y1 x2,y2 [hv] [driven] [strict] [noconnect] [noconstraint]",),
    summary="A rectangle from two opposite corners: four lines.",
    details="""
Its sides are perpendicular and parallel, with `hv` horizontal and vertical. `driven` adds the
lengths of two sides. `_0` to `_3` are the sides in the order bottom, right, top, left. What cannot
be applied is said; with `strict` it is an error.

```
bottom, right, top, left = add_rect 0,0 5,3 hv driven
length bottom 10
```
""",
    keywords=_RECTANGLE,
    arguments=("first", "second"),
)
def add_rect(session: Session, words: Words) -> Reply:
    """A rectangle from two opposite corners."""
    a, b = words.point("a corner"), words.point("the opposite corner")
    words.end()
    return _rectangle(session, words, [a.at, Vec(b.x, a.y), b.at, Vec(a.x, b.y)])


@command(
    "add_rect3",
    group="create",
    usage=("add_rect3 p1 p2 p3 [driven] [strict] [noconnect] [noconstraint]",),
    summary="A rectangle from three corners in order, in any direction.",
    details="The third corner gives the height: it is moved onto the normal of the first side.",
    keywords=tuple(word for word in _RECTANGLE if word != "hv"),
    arguments=("first", "second", "third"),
)
def add_rect3(session: Session, words: Words) -> Reply:
    """A rectangle from three corners."""
    a, b, c = (words.point(f"the {number} corner") for number in ("first", "second", "third"))
    words.end()
    side = b.at - a.at
    square = side.x * side.x + side.y * side.y
    if not square > 0.0:
        fail("E1220", "the first two corners of a rectangle are apart", b.token.span)
    height = ((c.y - b.y) * side.x - (c.x - b.x) * side.y) / square
    up = Vec(-side.y * height, side.x * height)
    return _rectangle(session, words, [a.at, b.at, b.at + up, a.at + up])


@command(
    "add_rectcenter",
    group="create",
    usage=("add_rectcenter cx,cy px,py [hv] [driven] [strict] [noconnect] [noconstraint]",),
    summary="A rectangle from its centre and one corner.",
    keywords=_RECTANGLE,
    arguments=("center", "corner"),
)
def add_rectcenter(session: Session, words: Words) -> Reply:
    """A rectangle from its centre and a corner."""
    center, corner = words.point("the centre"), words.point("a corner")
    words.end()
    dx, dy = abs(corner.x - center.x), abs(corner.y - center.y)
    x, y = center.x, center.y
    corners = [Vec(x - dx, y - dy), Vec(x + dx, y - dy), Vec(x + dx, y + dy), Vec(x - dx, y + dy)]
    return _rectangle(session, words, corners)


def _rectangle(session: Session, words: Words, corners: Sequence[Vec]) -> Reply:
    for word in ("hv", "driven", "strict"):
        words.refuse_together("noconstraint", word)
    added: list[Added] = []
    for a, b in zip(corners, [*corners[1:], corners[0]], strict=True):
        added.append(creating.add(session, words, "line", (a.x, a.y, b.x, b.y)))
    names = [one.entity.name for one in added]
    said = [] if "noconstraint" in words.flags else _hold(session, words, added)
    said += creating.drive(session, words, ("length", names[0]), ("length", names[1]))
    creating.leave_cursor(session, words, added[-1].entity, "p2")
    return creating.reply(f"rect: {' '.join(names)}", added, said)


def _hold(session: Session, words: Words, added: Sequence[Added]) -> list[str]:
    """Corners that `noconnect` left open, and the angles; what was refused, in words."""
    lines: list[Entity] = [one.entity for one in added]
    wanted: list[tuple[str, tuple[str, ...]]] = []
    if "noconnect" in words.flags:
        for line, after in zip(lines, [*lines[1:], lines[0]], strict=True):
            wanted.append(("coincident", (f"{line.name}.p2", f"{after.name}.p1")))
    if "hv" in words.flags:
        for line, kind in zip(lines, ["horizontal", "vertical"] * 2, strict=True):
            wanted.append((kind, (line.name,)))
    else:
        wanted.append(("perpendicular", (lines[0].name, lines[1].name)))
        wanted.append(("parallel", (lines[0].name, lines[2].name)))
        wanted.append(("parallel", (lines[1].name, lines[3].name)))
    return apply(session, words, wanted)


def apply(
    session: Session, words: Words, wanted: Sequence[tuple[str, tuple[str, ...]]]
) -> list[str]:
    """Constrain as far as possible; what was refused, in words, or with `strict` an error."""
    said = []
    for kind, args in wanted:
        try:
            with session.document.transaction(kind):
                session.editor.constrain(kind, args)
        except AraelError as error:
            if "strict" in words.flags:
                raise placed(error, words.span) from None
            said.append(f" [not {kind} {' '.join(args)}: {error.diagnostics[0].message}]")
    return said
