"""`fillet` and `chamfer`."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

from arael.diagnostics.records import AraelError, Diagnostic
from arael.sketch.commands.creating import placed_at
from arael.sketch.commands.cutting import report_lines, require_no_text
from arael.sketch.commands.numbers import shown
from arael.sketch.commands.reading import Operand, Words
from arael.sketch.commands.replies import Reply
from arael.sketch.commands.session import Session
from arael.sketch.commands.table import command
from arael.sketch.commands.tokens import Token, fail
from arael.sketch.document.document import Document
from arael.sketch.document.records import Amount, Constraint
from arael.sketch.geometry import Corner, Line, corner
from arael.sketch.geometry import chamfer as chamfer_of
from arael.sketch.geometry import fillet as fillet_of
from arael.sketch.transfer.corner import End, needs_anchor, to_anchor
from arael.sketch.transfer.report import Transfer


class _Spec(NamedTuple):
    """A corner as it was named: ``L0 L1`` or ``L0.p2``."""

    operands: tuple[Operand, ...]

    @property
    def text(self) -> str:
        return " ".join(one.handle for one in self.operands)

    @property
    def token(self) -> Token:
        return self.operands[0].token


@dataclass(frozen=True, slots=True)
class _Corner:
    """Two ends of lines that a coincident holds together."""

    ends: tuple[End, End]
    tie: Constraint
    at: Corner


class _Made(NamedTuple):
    entity: str
    dimension: str
    text: str


Cut = Callable[[Session, Words, _Corner, Amount, Transfer], _Made]


@command(
    "fillet",
    group="modify",
    usage=(
        "fillet L1 L2 r [notangent] [noradius]",
        "fillet L1.p2 r",
        "fillet L1 L2 L3.p1 ... r",
    ),
    summary="Round corners of lines with tangent arcs.",
    details="""
Any number of corners, each two lines or one end of a line, then the radius. The first arc's radius
dimension has the value or expression as it is written, those of the others refer to it by name;
`noradius` leaves the dimensions out, `notangent` the tangents. Corners that cannot be rounded are
listed as `FAILED`; the others are. What referred to a corner or to the full length of a line goes
to a point where the lines would meet.

```
add_rect 0,0 5,3 hv
fillet L0 L1 L1 L2 0.5
```
""",
    keywords=("notangent", "noradius"),
    arguments=("*corners",),
)
def fillet(session: Session, words: Words) -> Reply:
    """Round corners."""
    return _corners(session, words, "Filleted", "the radius", _round)


@command(
    "chamfer",
    group="modify",
    usage=("chamfer L1 L2 d", "chamfer L1.p2 d", "chamfer L1 L2 L3.p1 ... d"),
    summary="Bevel corners of lines.",
    details="""
Corners as with `fillet`, then the distance from the corner. A point stays at the corner, on both
lines; two dimensions hold its distances from the ends of the new line. The first has the value or
expression as it is written, all others refer to it by name.

```
add_rect 0,0 5,3 hv
chamfer L0 L1 L1 L2 0.5
```
""",
    arguments=("*corners",),
)
def chamfer(session: Session, words: Words) -> Reply:
    """Bevel corners."""
    return _corners(session, words, "Chamfered", "the distance", _bevel)


def _corners(session: Session, words: Words, verb: str, what: str, cut: Cut) -> Reply:
    specs = _read(words)
    token = words.next(what)
    amount = words.amount(what, "length", token)
    words.require_bounds(amount.number, token, what, above=0.0)
    words.end()
    document = session.document
    done = Transfer()
    made: list[_Made] = []
    lines: list[str] = []
    failed: list[AraelError] = []
    with document.transaction(words.statement.text):
        equal = _switch_off_equal(document, specs)
        first = ""
        for spec in specs:
            given = Amount(first, amount.number) if first else amount
            try:
                with document.transaction("corner"), placed_at(words):
                    mine = Transfer()
                    one = cut(session, words, _found(document, spec), given, mine)
                _add(done, mine)
            except AraelError as error:
                failed.append(error)
                lines.append(f"  {spec.text}: FAILED: {error.diagnostics[0].message}")
                continue
            first = first or one.dimension
            made.append(one)
            lines.append(f"  {spec.text}: {one.text}")
        if not made:
            raise failed[0]
        _switch_on_equal(session, equal, done)
    head = f"{verb} {len(made)} of {len(specs)} corners"
    names = tuple(one.entity for one in made)
    data = {"made": list(names), "failed": len(failed), **done.data}
    return Reply("\n".join([head, *lines, *report_lines(session, done)]), names, data=data)


def _read(words: Words) -> list[_Spec]:
    """Corners up to the last word, which is the size."""
    specs: list[_Spec] = []
    while len(words) > 1:
        one = words.operand("a line or an end of one (`L1`, `L1.p2`)", "line", "end")
        if one.entity.kind != "line":
            fail("E1256", f"expected an end of a line, found `{one.handle}`", one.token.span)
        if one.point:
            specs.append(_Spec((one,)))
        elif len(words) < 2:
            fail("E1251", f"`{one.handle}` needs the other line of the corner", one.token.span)
        else:
            specs.append(_Spec((one, words.operand("the other line", "line"))))
    if not specs:
        words.missing("corners (`L1 L2` or `L1.p2`) and a size")
    return specs


def _found(document: Document, spec: _Spec) -> _Corner:
    """The corner that was named; E1283 if there is none of two lines."""
    ends_of = [
        (constraint, ends)
        for constraint in document.constraints.values()
        if constraint.kind == "coincident" and constraint.active
        for ends in [_ends(document, constraint)]
        if ends is not None
    ]
    if len(spec.operands) == 2:
        names = {one.handle for one in spec.operands}
        fitting = [(c, e) for c, e in ends_of if {e[0].line, e[1].line} == names]
    else:
        fitting = [(c, e) for c, e in ends_of if spec.text in (e[0].handle, e[1].handle)]
    if not fitting:
        names_ = " and ".join(one.handle for one in spec.operands)
        what = "share no corner" if len(spec.operands) == 2 else "is no corner of two lines"
        hint = "the ends are to be tied by a `coincident` of their own, not through a point"
        fail("E1283", f"{names_} {what}", spec.token.span, "", hint)
    if len(fitting) > 1:
        others = ", ".join(f"{e[0].handle} {e[1].handle}" for _, e in fitting)
        fail("E1283", f"{spec.text} names {len(fitting)} corners: {others}", spec.token.span)
    tie, ends = fitting[0]
    for end in ends:
        require_no_text(document.entities[end.line])
    if len(spec.operands) == 2 and ends[0].line != spec.operands[0].handle:
        ends = ends[::-1]
    a, b = (Line((n[0], n[1]), (n[2], n[3])) for n in (
        document.numbers_of(end.line).tolist() for end in ends))  # fmt: skip
    found = corner(a, b)
    if found is None or abs(_sine(found)) < 1e-9:
        fail("E1283", f"{spec.text}: the lines run in one direction", spec.token.span)
    return _Corner(ends, tie, found)


def _sine(at: Corner) -> float:
    return at.first[0] * at.second[1] - at.first[1] * at.second[0]


def _ends(document: Document, constraint: Constraint) -> tuple[End, End] | None:
    ends = []
    for arg in constraint.args:
        name, _, point = arg.partition(".")
        if document.entities[name].kind != "line":
            return None
        ends.append(End(name, point))
    return (ends[0], ends[1]) if ends[0].line != ends[1].line else None


def _require_length(
    document: Document, found: _Corner, size: float, trim: float, what: str
) -> None:
    """E1283 with the largest size, if what is cut off is not shorter than a line."""
    for end in found.ends:
        n = document.numbers_of(end.line).tolist()
        length = math.dist(n[:2], n[2:])
        if not trim < length * (1.0 - 1e-9):
            raise AraelError(
                Diagnostic(
                    "E1283",
                    f"{end.line} is {shown(length)} long, {what} takes {shown(trim)} of it",
                    help=(f"a size below {shown(size * _shortest(document, found) / trim)} fits",),
                )
            )


def _shortest(document: Document, found: _Corner) -> float:
    numbers = (document.numbers_of(end.line).tolist() for end in found.ends)
    return min(math.dist(n[:2], n[2:]) for n in numbers)


def _open(session: Session, found: _Corner, always: bool, new: str, done: Transfer) -> str:
    """Break the corner; the anchor that stays there, empty if nothing needs one."""
    document, tie = session.document, found.tie
    document.remove("constraints", tie.name)
    done.dropped[tie.name] = f"coincident {' '.join(tie.args)} (the corner is cut off)"
    anchor = ""
    if always or needs_anchor(document, found.ends, tie.name):
        anchor = document.add_entity("point", found.at.point, construction=True).name
    to_anchor(document, found.ends, anchor, new, done)
    return anchor


def _place(document: Document, end: End, at: tuple[float, float]) -> None:
    offset = document.point_at(end.handle)
    document.set_values([offset, offset + 1], at)


def _constrain(session: Session, kind: str, args: tuple[str, ...], done: Transfer) -> None:
    """Constrain; what follows from the rest already is left out."""
    try:
        with session.document.transaction(kind):
            done.added.append(session.editor.constrain(kind, args).name)
    except AraelError as error:
        if error.diagnostics[0].code not in ("E1230", "E1232"):
            raise
        done.implied.append(f"{kind} {' '.join(args)}")


def _round(session: Session, words: Words, found: _Corner, amount: Amount, done: Transfer) -> _Made:
    document = session.document
    shape = fillet_of(found.at, amount.number)
    assert shape is not None
    _require_length(document, found, amount.number, shape.trim, "the arc")
    arc = shape.arc
    numbers = [*arc.center, *arc.start, *arc.end, arc.radius]
    name = document.add_entity("arc", numbers).name
    anchor = _open(session, found, False, name, done)
    for end, contact in zip(found.ends, shape.contacts, strict=True):
        _place(document, end, contact)
    starts = math.dist(arc.start, shape.contacts[0]) < math.dist(arc.end, shape.contacts[0])
    points = ("start", "end") if starts else ("end", "start")
    if anchor:
        _put_anchor(document, found, anchor, done)
    for end, point in zip(found.ends, points, strict=True):
        _constrain(session, "coincident", (end.handle, f"{name}.{point}"), done)
    if "notangent" not in words.flags:
        for end in found.ends:
            _constrain(session, "tangent", (end.line, name), done)
    dimension = ""
    if "noradius" not in words.flags:
        dimension = session.editor.dimension("radius", (name,), value=amount).name
        done.added.append(dimension)
    return _Made(name, dimension, f"{name} radius {shown(amount.number)}")


def _put_anchor(document: Document, found: _Corner, anchor: str, done: Transfer) -> None:
    """The anchor on both lines; put without a verdict: it is what the rest is measured from."""
    for end in found.ends:
        name = document.next_name("C")
        document.put("constraints", Constraint(name, "point_on", (anchor, end.line)))
        done.added.append(name)


def _bevel(session: Session, words: Words, found: _Corner, amount: Amount, done: Transfer) -> _Made:
    document = session.document
    _require_length(document, found, amount.number, amount.number, "the chamfer")
    shape = chamfer_of(found.at, amount.number)
    name = document.add_entity("line", [*shape.p1, *shape.p2]).name
    anchor = _open(session, found, True, name, done)
    for end, at in zip(found.ends, (shape.p1, shape.p2), strict=True):
        _place(document, end, at)
    _put_anchor(document, found, anchor, done)
    for end, point in zip(found.ends, ("p1", "p2"), strict=True):
        _constrain(session, "coincident", (f"{name}.{point}", end.handle), done)
    first, second = found.ends
    primary = session.editor.dimension("distance", (anchor, first.handle), value=amount).name
    follower = Amount(primary, amount.number)
    secondary = session.editor.dimension("distance", (anchor, second.handle), value=follower).name
    done.added += [primary, secondary]
    return _Made(name, primary, f"{name} distance {shown(amount.number)}, corner at {anchor}")


def _switch_off_equal(document: Document, specs: list[_Spec]) -> list[Constraint]:
    """Equal lengths of the lines are looked at when all corners are cut."""
    lines = {one.entity.name for spec in specs for one in spec.operands}
    for constraint in list(document.constraints.values()):
        # the other line of a corner that was named by one end
        if constraint.kind == "coincident":
            names = {arg.partition(".")[0] for arg in constraint.args}
            if any(spec.text in constraint.args for spec in specs):
                lines |= names
    found = [
        one
        for one in document.constraints.values()
        if one.kind == "equal" and one.active and lines & set(one.args)
    ]
    for one in found:
        document.put("constraints", replace(one, active=False))
    return found


def _switch_on_equal(session: Session, found: list[Constraint], done: Transfer) -> None:
    document = session.document
    for one in found:
        lengths = [session.editor.measure("length", (arg,)) for arg in one.args]
        try:
            if abs(lengths[0] - lengths[1]) > 1e-7 * max(lengths):
                raise AraelError(Diagnostic("E1231", "the lines are not equally long any more"))
            with document.transaction("equal"):
                session.editor.change_constraint(one.name, active=True)
        except AraelError as error:
            document.remove("constraints", one.name)
            reason = error.diagnostics[0].message
            done.dropped[one.name] = f"equal {' '.join(one.args)} ({reason})"


def _add(done: Transfer, mine: Transfer) -> None:
    done.added += mine.added
    done.moved |= mine.moved
    done.implied += mine.implied
    done.dropped |= mine.dropped
    done.rewritten += [one for one in mine.rewritten if one not in done.rewritten]
