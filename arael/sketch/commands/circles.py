"""Circles and circular arcs."""

from __future__ import annotations

import math

from arael.sketch.commands import creating
from arael.sketch.commands.lines import apply
from arael.sketch.commands.numbers import place, shown
from arael.sketch.commands.reading import Operand, Words
from arael.sketch.commands.replies import Reply
from arael.sketch.commands.session import Session
from arael.sketch.commands.table import command
from arael.sketch.commands.tokens import fail
from arael.sketch.geometry import (
    Arc,
    Circle,
    Line,
    TangentCircle,
    arc_through,
    circle_through,
    circles_tangent_to_three,
    circles_tangent_to_two,
)

_CIRCLE = (*creating.COMMON, "driven")
_TANGENT = ("noconnect", "noconstraint", "driven", "strict", "nocursor", "quiet", "constr")


@command(
    "add_circle",
    group="create",
    usage=("add_circle cx,cy radius [noconnect] [nocursor] [driven] [quiet] [constr]",),
    summary="A circle from its centre and radius.",
    details="A centre within 1e-3 of another point becomes coincident with it; `driven` adds the "
    "radius as a dimension.",
    keywords=_CIRCLE,
    arguments=("center", "radius"),
)
def add_circle(session: Session, words: Words) -> Reply:
    """A circle."""
    center = words.point("the centre")
    radius = words.number("a radius", "length", above=0.0)
    words.end()
    return _circle(session, words, Circle((center.x, center.y), radius))


@command(
    "add_circle2",
    group="create",
    usage=("add_circle2 p1 p2 [noconnect] [nocursor] [driven]",),
    summary="A circle from two opposite points on it.",
    keywords=_CIRCLE,
    arguments=("first", "second"),
)
def add_circle2(session: Session, words: Words) -> Reply:
    """A circle from two opposite points."""
    a, b = words.point("a point of the circle"), words.point("the opposite point")
    words.end()
    center = 0.5 * (a.x + b.x), 0.5 * (a.y + b.y)
    radius = 0.5 * math.hypot(b.x - a.x, b.y - a.y)
    if not radius > 0.0:
        fail("E1220", "the two points of a circle are apart", b.token.span)
    return _circle(session, words, Circle(center, radius))


@command(
    "add_circle3",
    group="create",
    usage=("add_circle3 p1 p2 p3 [noconnect] [nocursor] [driven]",),
    summary="A circle through three points.",
    keywords=_CIRCLE,
    arguments=("first", "second", "third"),
)
def add_circle3(session: Session, words: Words) -> Reply:
    """A circle through three points."""
    a, b, c = (words.point(f"the {number} point") for number in ("first", "second", "third"))
    words.end()
    found = circle_through((a.x, a.y), (b.x, b.y), (c.x, c.y))
    if found is None:
        fail("E1220", "there is no circle through three points of a line", c.token.span)
    return _circle(session, words, found)


def _circle(session: Session, words: Words, circle: Circle) -> Reply:
    (x, y), radius = circle.center, circle.radius
    added = creating.add(session, words, "circle", (x, y, radius))
    name = added.entity.name
    dimensions = creating.drive(session, words, ("radius", name))
    creating.leave_cursor(session, words, added.entity, "center")
    return creating.reply(f"{name}: center={place(x, y)} r={shown(radius)}", [added], dimensions)


@command(
    "add_circle2t",
    group="create",
    usage=("add_circle2t L0 L1 radius [noconnect] [noconstraint] [driven] [strict]",),
    summary="A circle of a radius tangent to two lines.",
    details="""
The one of the four such circles that touches both lines between their ends. If none does, or
several do, the command is refused: shorten or lengthen the lines to say which is meant.
""",
    keywords=_TANGENT,
    arguments=("first", "second", "radius"),
)
def add_circle2t(session: Session, words: Words) -> Reply:
    """A circle tangent to two lines."""
    lines = [words.operand("a line", "line"), words.operand("another line", "line")]
    radius = words.number("a radius", "length", above=0.0)
    words.end()
    a, b = (_line(session, one) for one in lines)
    found = circles_tangent_to_two(a, b, radius)
    return _tangent_circle(session, words, lines, found)


@command(
    "add_circle3t",
    group="create",
    usage=("add_circle3t L0 L1 L2 [noconnect] [noconstraint] [driven] [strict]",),
    summary="A circle tangent to three lines, such as the incircle of a triangle.",
    details="Of the circles that touch all three lines the one that does so between their ends.",
    keywords=_TANGENT,
    arguments=("first", "second", "third"),
)
def add_circle3t(session: Session, words: Words) -> Reply:
    """A circle tangent to three lines."""
    lines = [words.operand(f"{n} line", "line") for n in ("a", "a second", "a third")]
    words.end()
    a, b, c = (_line(session, one) for one in lines)
    return _tangent_circle(session, words, lines, circles_tangent_to_three(a, b, c))


def _line(session: Session, operand: Operand) -> Line:
    x1, y1, x2, y2 = session.document.numbers_of(operand.handle).tolist()
    return Line((x1, y1), (x2, y2))


def _tangent_circle(
    session: Session, words: Words, lines: list[Operand], found: list[TangentCircle]
) -> Reply:
    words.refuse_together("noconstraint", "strict")
    touching = [one for one in found if one.on_segments]
    if len(touching) != 1:
        reason = (
            "no such circle touches all of them between their ends"
            if not touching
            else f"{len(touching)} such circles touch all of them between their ends"
        )
        names = ", ".join(f"`{one.handle}`" for one in lines)
        help_ = "shorten or lengthen the lines to say which is meant"
        fail("E1272", f"circle tangent to {names}: {reason}", words.span, "", help_)
    circle = touching[0].circle
    (x, y), radius = circle.center, circle.radius
    added = creating.add(session, words, "circle", (x, y, radius))
    name = added.entity.name
    said: list[str] = []
    if "noconstraint" not in words.flags:
        said += apply(session, words, [("tangent", (one.handle, name)) for one in lines])
    said += creating.drive(session, words, ("radius", name))
    creating.leave_cursor(session, words, added.entity, "center")
    return creating.reply(f"{name}: center={place(x, y)} r={shown(radius)}", [added], said)


@command(
    "add_arc",
    group="create",
    usage=(
        "add_arc start end through [noconnect] [notangent] [nocursor] [driven] [quiet] [constr]",
    ),
    summary="A circular arc from its start to its end through a third point.",
    details="""
Its ends and centre within 1e-3 of another point become coincident with it; where it continues a
line or arc within 1 degree it becomes tangent. `driven` adds radius and sweep as dimensions.
""",
    keywords=(*creating.COMMON, "notangent", "driven"),
    arguments=("start", "end", "through"),
)
def add_arc(session: Session, words: Words) -> Reply:
    """A circular arc."""
    a, b = words.point("the start"), words.point("the end")
    c = words.point("a point between them")
    words.end()
    found = arc_through((a.x, a.y), (b.x, b.y), (c.x, c.y))
    if found is None:
        help_ = "choose a third point beside the straight line from start to end"
        fail("E1220", "there is no arc through three points of a line", c.token.span, "", help_)
    return _arc(session, words, found, (a.x, a.y), (b.x, b.y))


def _arc(
    session: Session,
    words: Words,
    arc: Arc,
    start: tuple[float, float],
    end: tuple[float, float],
) -> Reply:
    clockwise = arc.sweep < 0.0
    first, last = (end, start) if clockwise else (start, end)
    numbers = (*arc.center, *first, *last, arc.radius)
    added = creating.add(session, words, "arc", numbers, clockwise=clockwise)
    name = added.entity.name
    dimensions = creating.drive(session, words, ("radius", name), ("sweep", name))
    creating.leave_cursor(session, words, added.entity, "end")
    text = f"{name}: center={place(*arc.center)} r={shown(arc.radius)}"
    return creating.reply(text, [added], dimensions)
