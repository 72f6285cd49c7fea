"""Ellipses and elliptic arcs."""

from __future__ import annotations

import math

from arael.sketch.commands import creating
from arael.sketch.commands.numbers import place, shown
from arael.sketch.commands.reading import Words
from arael.sketch.commands.replies import Reply
from arael.sketch.commands.session import Session
from arael.sketch.commands.table import command
from arael.sketch.commands.tokens import fail
from arael.sketch.geometry import (
    EllipticArc,
    elliptic_arc,
    elliptic_arc_tangent,
    elliptic_arc_through,
)
from arael.sketch.geometry.vectors import TURN

_ARC = (*creating.COMMON, "notangent", "driven")


@command(
    "add_ellipse",
    group="create",
    usage=("add_ellipse cx,cy rx ry rotation [noconnect] [nocursor] [driven] [quiet] [constr]",),
    summary="An ellipse from its centre, its two radii and the direction of the first, in degrees.",
    details="`driven` adds both radii as dimensions (`radius`, `radius_b`).",
    keywords=(*creating.COMMON, "driven"),
    arguments=("center", "rx", "ry", "rotation="),
)
def add_ellipse(session: Session, words: Words) -> Reply:
    """An ellipse."""
    center = words.point("the centre")
    rx = words.number("the first radius", "length", above=0.0)
    ry = words.number("the second radius", "length", above=0.0)
    rotation = words.number("the rotation in degrees", "angle") if words else 0.0
    words.end()
    numbers = (center.x, center.y, rx, ry, math.radians(rotation))
    added = creating.add(session, words, "ellipse", numbers)
    name = added.entity.name
    dimensions = creating.drive(session, words, ("radius", name), ("radius_b", name))
    creating.leave_cursor(session, words, added.entity, "center")
    text = (
        f"{name}: center={place(center.x, center.y)} rx={shown(rx)} ry={shown(ry)} "
        f"rot={shown(rotation)}deg"
    )
    return creating.reply(text, [added], dimensions)


@command(
    "add_earc",
    group="create",
    usage=(
        "add_earc p1 p2 rx ry rotation [large] [cw] [noconnect] [notangent] [nocursor] [driven]",
    ),
    summary="An elliptic arc between two points, as in SVG: radii, rotation, large, clockwise.",
    details="""
Radii that are too small for the distance of the points are enlarged. Without `large` the shorter
of the two arcs, without `cw` the counter-clockwise one.
""",
    keywords=(*_ARC, "large", "cw"),
    arguments=("first", "second", "rx", "ry", "rotation="),
)
def add_earc(session: Session, words: Words) -> Reply:
    """An elliptic arc between two points."""
    a, b = words.point("the start"), words.point("the end")
    rx = words.number("the first radius", "length", above=0.0)
    ry = words.number("the second radius", "length", above=0.0)
    rotation = words.number("the rotation in degrees", "angle") if words else 0.0
    words.end()
    found = elliptic_arc(
        (a.x, a.y),
        (b.x, b.y),
        rx,
        ry,
        math.radians(rotation),
        large="large" in words.flags,
        clockwise="cw" in words.flags,
    )
    if found is None:
        fail("E1220", "the two ends of an arc are apart", b.token.span)
    return _added(session, words, found)


@command(
    "add_earc3",
    group="create",
    usage=("add_earc3 p1 p2 near rx ry [noconnect] [nocursor] [driven]",),
    summary="An elliptic arc between two points with given radii that passes near a third.",
    keywords=_ARC,
    arguments=("first", "second", "near", "rx", "ry"),
)
def add_earc3(session: Session, words: Words) -> Reply:
    """An elliptic arc near a third point."""
    a, b = words.point("the start"), words.point("the end")
    c = words.point("a point near the arc")
    rx = words.number("the first radius", "length", above=0.0)
    ry = words.number("the second radius", "length", above=0.0)
    words.end()
    found = elliptic_arc_through((a.x, a.y), (b.x, b.y), (c.x, c.y), rx, ry)
    if found is None:
        fail("E1220", "the two ends of an arc are apart", b.token.span)
    return _added(session, words, found)


@command(
    "add_earc_center",
    group="create",
    usage=(
        "add_earc_center cx,cy rx ry rotation start end [cw] "
        "[noconnect] [notangent] [nocursor] [driven]",
    ),
    summary="An elliptic arc from its centre, radii, rotation, and start and end angle in degrees.",
    details="The angles are those of the ellipse's parameter: 90 is the end of the second radius.",
    keywords=(*_ARC, "cw"),
    arguments=("center", "rx", "ry", "rotation", "start", "end"),
)
def add_earc_center(session: Session, words: Words) -> Reply:
    """An elliptic arc from its centre."""
    center = words.point("the centre")
    rx = words.number("the first radius", "length", above=0.0)
    ry = words.number("the second radius", "length", above=0.0)
    rotation = words.number("the rotation in degrees", "angle")
    start = math.radians(words.number("the start angle in degrees", "angle"))
    end = math.radians(words.number("the end angle in degrees", "angle"))
    words.end()
    sweep = (end - start) % TURN or TURN
    if "cw" in words.flags:
        sweep = -((start - end) % TURN or TURN)
    arc = EllipticArc((center.x, center.y), rx, ry, math.radians(rotation), start, sweep)
    return _added(session, words, arc)


@command(
    "add_earc_tangent",
    group="create",
    usage=("add_earc_tangent p1 t1 p2 t2 [bulge] [noconnect] [notangent] [nocursor] [driven]",),
    summary="An elliptic arc from ends and directions.",
    details="""
`bulge` chooses among the ellipses that have these tangents: the one that passes beside the middle
of the chord at `bulge` times half the chord, on the side where the normals of the ends meet. 1, its
value if left out, makes half a circle of opposite directions. Where no arc arrives in the second
direction, one may arrive against it.
`@cursor @tangent` goes on from where the last line or arc ended.
""",
    keywords=_ARC,
    arguments=("start", "first", "end", "last", "bulge="),
)
def add_earc_tangent(session: Session, words: Words) -> Reply:
    """An elliptic arc from ends and directions."""
    a = words.point("the start")
    d = words.direction("the direction at the start")
    return _tangent(session, words, (a.x, a.y), (d.x, d.y))


@command(
    "add_earc_rtangent",
    group="create",
    usage=("add_earc_rtangent p2 t2 [bulge] [noconnect] [notangent] [nocursor] [driven]",),
    summary="An elliptic arc that goes on from the last line or arc.",
    details="The same as `add_earc_tangent @cursor @tangent p2 t2`.",
    keywords=_ARC,
    arguments=("end", "last", "bulge="),
)
def add_earc_rtangent(session: Session, words: Words) -> Reply:
    """An elliptic arc that goes on from the cursor."""
    state = session.state
    if state.cursor is None or state.tangent is None:
        help_ = "add a line or an arc first, or use `add_earc_tangent`"
        fail("E1259", "nothing ends at the cursor", words.span, "", help_)
    start, first = state.cursor, state.tangent
    return _tangent(session, words, (start.x, start.y), (first.x, first.y))


def _tangent(
    session: Session, words: Words, start: tuple[float, float], first: tuple[float, float]
) -> Reply:
    end = words.point("the end")
    last = words.direction("the direction at the end")
    bulge = words.number("the bulge", above=0.0) if words else 1.0
    words.end()
    found = elliptic_arc_tangent(start, first, (end.x, end.y), (last.x, last.y), bulge)
    if found is None:
        # the line of the end's tangent, from the other side
        found = elliptic_arc_tangent(start, first, (end.x, end.y), (-last.x, -last.y), bulge)
    if found is None:
        help_ = "turn one of the directions, or choose another bulge"
        message = "no elliptic arc has these ends and directions"
        fail("E1272", message, end.token.span, "", help_)
    return _added(session, words, found)


def _added(session: Session, words: Words, arc: EllipticArc) -> Reply:
    clockwise = arc.sweep < 0.0
    start, end = arc.start, arc.end
    first, last = (end, start) if clockwise else (start, end)
    numbers = (*arc.center, *first, *last, arc.rx, arc.ry, arc.rotation)
    added = creating.add(session, words, "earc", numbers, clockwise=clockwise)
    name = added.entity.name
    dimensions = creating.drive(session, words, ("radius", name), ("radius_b", name))
    creating.leave_cursor(session, words, added.entity, "end")
    text = (
        f"{name}: center={place(*arc.center)} rx={shown(arc.rx)} ry={shown(arc.ry)} "
        f"rot={shown(math.degrees(arc.rotation))}deg"
    )
    return creating.reply(text, [added], dimensions)
