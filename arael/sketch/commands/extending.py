"""`extend`: a line or arc goes on until it meets another curve."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

from arael.sketch.commands.creating import placed_at
from arael.sketch.commands.cutting import curve_of_entity
from arael.sketch.commands.describing import entity_line, record_line
from arael.sketch.commands.numbers import exact
from arael.sketch.commands.reading import Operand, Words
from arael.sketch.commands.replies import Reply
from arael.sketch.commands.session import Session
from arael.sketch.commands.table import command
from arael.sketch.commands.tokens import Token, fail
from arael.sketch.document.records import Amount, Dimension, Entity
from arael.sketch.expressions.reading import literal
from arael.sketch.geometry import Arc, Curve, EllipticArc, intersections
from arael.sketch.transfer.pieces import high_end, low_end

_EXTENTS = ("length", "sweep", "arc_length", "total_length", "area")


class _Reach(NamedTuple):
    """Where an extension meets a curve: how far from the end, the end, the place, the curve."""

    length: float
    end: str
    at: tuple[float, float]
    other: str


@command(
    "extend",
    group="modify",
    usage=(
        "extend L0 to L1 [forward] [backward] [nopin]",
        "extend L0 x,y [nopin]",
        "extend L0 forward [nopin]",
    ),
    summary="Lengthen a line or arc up to another curve.",
    details="""
`to` names the curve; with a coordinate the end next to it goes on to the first curve that it meets.
`forward` lengthens at the end (p2), `backward` at the start (p1); without them `to` takes the end
that is nearer to the curve. The new end is held on the curve unless `nopin`. A literal length,
sweep or arc length gets its new value; one with an expression only measures from then on.

```
extend L0 to L1
```
""",
    keywords=("forward", "backward", "nopin"),
    arguments=("entity", "*where"),
)
def extend(session: Session, words: Words) -> Reply:
    """Lengthen a line or arc."""
    words.refuse_together("forward", "backward")
    target = words.operand("a line or arc", "curve")
    if target.entity.kind not in ("line", "arc", "earc"):
        message = f"{target.handle} is a {target.entity.kind}: only lines and arcs go on"
        fail("E1284", message, target.token.span)
    curve = curve_of_entity(session, target.handle)
    found = _reach(session, words, target, curve)
    document = session.document
    with document.transaction(words.statement.text), placed_at(words):
        offset = document.point_at(f"{target.handle}.{found.end}")
        free = _free_extents(session, target.entity)
        document.set_values([offset, offset + 1], found.at)
        changed = [_follow(session, one) for one in free]
        session.editor.solve()
        pins = []
        if "nopin" not in words.flags:
            handle = f"{target.handle}.{found.end}"
            pins.append(session.editor.constrain("point_on", (handle, found.other)).name)
    lines = [f"Extended {entity_line(document, document.entities[target.handle])}"]
    lines += [f"  added: {record_line(session, document.constraints[name])}" for name in pins]
    lines += [f"  changed: {record_line(session, document.dimensions[n])}" for n in changed]
    data = {"entity": target.handle, "end": found.end, "added": pins, "changed": changed}
    return Reply("\n".join(lines), remembered=False, data=data)


def _reach(session: Session, words: Words, target: Operand, curve: Curve) -> _Reach:
    low, high = low_end(target.entity), high_end(target.entity)
    first, last = ("start", "end") if target.entity.kind != "line" else ("p1", "p2")
    chosen = last if "forward" in words.flags else first if "backward" in words.flags else ""
    ends = (chosen,) if chosen else (low, high)
    others = [
        one.name
        for one in session.document.entities.values()
        if one.kind != "point" and one.name != target.handle
    ]
    token: Token = target.token
    if words.accept("to"):
        to = words.operand("a curve to reach", "curve")
        if to.handle == target.handle:
            fail("E1281", f"{to.handle} cannot reach itself", to.token.span)
        token, others = to.token, [to.handle]
    elif words:
        place = words.point("a coordinate, or `to` and a curve")
        token = place.token
        if not chosen:
            gaps = {
                p: _gap(e, (place.x, place.y)) for p, e in ((low, curve.start), (high, curve.end))
            }
            ends = (min(gaps, key=lambda one: gaps[one]),)
    elif not chosen:
        words.missing("`to` and a curve, a coordinate, `forward` or `backward`")
    words.end()
    reaches = [
        reach for other in others for reach in _reaches(session, curve, other, low, high)
        if reach.end in ends
    ]  # fmt: skip
    if not reaches:
        where = f" at {ends[0]}" if len(ends) == 1 else ""
        what = others[0] if len(others) == 1 else "anything"
        hint = "extensions end on the drawn part of a curve"
        fail("E1281", f"{target.handle} does not reach {what}{where}", token.span, "", hint)
    return min(reaches)


def _reaches(session: Session, curve: Curve, other: str, low: str, high: str) -> list[_Reach]:
    found = []
    least = 1e-7 * curve.bounds().size
    # parameters of an arc come back after a turn
    turn = math.tau / abs(curve.sweep) if isinstance(curve, Arc | EllipticArc) else 0.0
    for contact in intersections(curve, curve_of_entity(session, other), extend_a=True):
        if contact.kind == "overlap":
            continue
        if min(_gap(contact.point, curve.start), _gap(contact.point, curve.end)) <= least:
            continue
        t = contact.t % turn if turn else contact.t
        if t > 1.0:
            found.append(_Reach(t - 1.0, high, contact.point, other))
        if turn and t > 1.0:
            found.append(_Reach(turn - t, low, contact.point, other))
        elif t < 0.0:
            found.append(_Reach(-t, low, contact.point, other))
    return found


def _gap(a: tuple[float, float], b: tuple[float, float]) -> float:
    return math.dist(a, b)


def _free_extents(session: Session, entity: Entity) -> list[Dimension]:
    """Dimensions of the length that would hold the end back."""
    return [
        one
        for one in session.document.dimensions.values()
        if one.kind in _EXTENTS and entity.name in one.args and one.active and not one.derived
    ]


def _follow(session: Session, one: Dimension) -> str:
    now = abs(session.editor.measure(one.kind, one.args, one.mode))
    value = one.value
    if value is not None and literal(value.text) is not None:
        session.document.put("dimensions", replace(one, value=Amount(exact(now), now)))
    else:
        measured = Amount(exact(now), now)
        changed = replace(one, value=measured, low=None, high=None, derived=True)
        session.document.put("dimensions", changed)
    return one.name
