"""`split` and `trim`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from arael.diagnostics.records import AraelError, Diagnostic
from arael.sketch.commands.creating import placed_at
from arael.sketch.commands.describing import entity_line, record_line
from arael.sketch.commands.numbers import shown
from arael.sketch.commands.reading import Operand, Words
from arael.sketch.commands.replies import Reply
from arael.sketch.commands.session import Session
from arael.sketch.commands.table import command
from arael.sketch.commands.tokens import Token, fail
from arael.sketch.document.records import Entity
from arael.sketch.geometry import Curve, curve_of, intersections, numbers_of
from arael.sketch.transfer.carry import carry
from arael.sketch.transfer.pieces import Division, Part, high_end, low_end
from arael.sketch.transfer.report import Transfer

#: Contacts closer to an end than this part of the curve's size are that end.
_AT_END = 1e-7


class _Cut(NamedTuple):
    """A place where another curve crosses: parameter on the target, and that curve's name."""

    t: float
    cutter: str


def curve_of_entity(session: Session, name: str) -> Curve:
    """Shape of an entity."""
    entity = session.document.entities[name]
    return curve_of(entity.kind, session.document.numbers_of(name).tolist())


def require_no_text(entity: Entity) -> None:
    """Refuse to cut the frame of a text; AraelError E1286."""
    if entity.text:
        message = f"{entity.name} is the frame of a text, which cannot be cut"
        help_ = "`delete` takes the text away", "`set_text` changes what it reads"
        raise AraelError(Diagnostic("E1286", message, help=help_))


@command(
    "split",
    group="modify",
    usage=("split L0 x,y [r] [nopin]", "split L0 by L1 [L2 ...] [nopin]"),
    summary="Cut a curve where others cross it; all pieces stay.",
    details="""
A coordinate is projected onto the curve, which is cut at the crossings on both sides of it; with
`r` it is to be within that distance. Behind `by` stand the cutters, at all of whose crossings it is
cut. Every piece is a new entity (`_0`, `_1`, ...); constraints, dimensions and expressions go over
to the pieces and keep their names, and what was added, moved, copied or dropped is listed. Cut ends
are connected and held on the cutter (`nopin`: not held).

```
a, b = split L0 by L1
delete b
```
""",
    keywords=("nopin",),
    arguments=("entity", "*where"),
)
def split(session: Session, words: Words) -> Reply:
    """Cut a curve and keep all pieces."""
    target, curve = _target(words, session)
    if words.accept("by"):
        cutters = _cutters(words, target)
        words.end()
        cuts = [cut for one in cutters for cut in _crossings_with(session, target, curve, one)]
    else:
        t, token = _projected(words, curve)
        words.end()
        around = _crossings(session, target.entity, curve)
        low, high = _bracket(curve, around, t)
        cuts = [one for one in (low, high) if one is not None]
        if not cuts:
            _nothing_crosses(target, token)
    cuts = _distinct(cuts)
    if curve.closed and len(cuts) < 2:
        _too_few(target)
    return _cut(session, words, target.entity, curve, cuts, None)


@command(
    "trim",
    group="modify",
    usage=(
        "trim L0 x,y [r] [nopin]",
        "trim L0 by L1 L2 [nopin]",
        "trim L0 by L1 forward [nopin]",
        "trim L0 by L1 backward [nopin]",
    ),
    summary="Cut a curve where others cross it, and delete one stretch.",
    details="""
With a coordinate the stretch between the crossings on both sides of it goes; if nothing crosses,
the whole entity. `by` two cutters deletes what is between them; `forward` deletes from the crossing
that is nearest to the end (p2), `backward` from the one nearest to the start (p1). Everything else
is as with `split`.
""",
    keywords=("nopin", "forward", "backward"),
    arguments=("entity", "*where"),
)
def trim(session: Session, words: Words) -> Reply:
    """Cut a curve and delete a stretch."""
    words.refuse_together("forward", "backward")
    target, curve = _target(words, session)
    if words.accept("by"):
        cutters = _cutters(words, target)
        words.end()
        span = _span_by(session, words, target, curve, cutters)
    else:
        towards = sorted(words.flags & {"forward", "backward"})
        if towards:
            message = f"`{towards[0]}` belongs to `trim ... by`"
            fail("E1252", message, words.statement.span, "", "name the cutter: `trim L0 by L1`")
        t, _ = _projected(words, curve)
        words.end()
        around = _crossings(session, target.entity, curve)
        span = _bracket(curve, around, t)
    if span == (None, None):
        return _deleted_whole(session, target.entity)
    if curve.closed and (span[0] is None or span[1] is None or span[0] == span[1]):
        _too_few(target)
    cuts = _distinct([one for one in span if one is not None])
    return _cut(session, words, target.entity, curve, cuts, span)


def _target(words: Words, session: Session) -> tuple[Operand, Curve]:
    target = words.operand("a curve to cut", "curve")
    with placed_at(words):
        require_no_text(target.entity)
    return target, curve_of_entity(session, target.handle)


def _cutters(words: Words, target: Operand) -> list[Operand]:
    found = words.operands("a curve that cuts", "curve", whole=True)
    for one in found:
        if one.handle == target.handle:
            fail("E1281", f"{one.handle} cannot cut itself", one.token.span)
    return list({one.handle: one for one in found}.values())


def _projected(words: Words, curve: Curve) -> tuple[float, Token]:
    place = words.point("a coordinate, or `by` and the cutters")
    found = curve.nearest((place.x, place.y))
    if words:
        most = words.number("the search radius", "length", above=0.0)
        if found.distance > most:
            message = f"{place.token.text} is {shown(found.distance)} away, more than {shown(most)}"
            fail("E1280", message, place.token.span, "", "give a place nearer to the curve")
    return found.t, place.token


def _crossings(session: Session, target: Entity, curve: Curve) -> list[_Cut]:
    """Where any other curve meets the target between its ends."""
    found: list[_Cut] = []
    for other in session.document.entities.values():
        if other.name != target.name and other.kind != "point":
            found += _meets(session, curve, other.name)
    return _distinct(found)


def _meets(session: Session, curve: Curve, cutter: str) -> list[_Cut]:
    found = []
    least = _AT_END * curve.bounds().size
    for contact in intersections(curve, curve_of_entity(session, cutter)):
        at_end = not curve.closed and any(
            _gap(contact.point, end) <= least for end in (curve.start, curve.end)
        )
        if contact.kind != "overlap" and not at_end:
            found.append(_Cut(contact.t % 1.0 if curve.closed else contact.t, cutter))
    return found


def _gap(a: Sequence[float], b: Sequence[float]) -> float:
    return float(((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2) ** 0.5)


def _crossings_with(session: Session, target: Operand, curve: Curve, cutter: Operand) -> list[_Cut]:
    found = _meets(session, curve, cutter.handle)
    if not found:
        message = f"{cutter.handle} does not cross {target.handle} between its ends"
        fail("E1281", message, cutter.token.span, "", "`trim` and `split` cut at crossings only")
    return found


def _distinct(cuts: Sequence[_Cut]) -> list[_Cut]:
    """Cuts by parameter, each place once."""
    kept: list[_Cut] = []
    for cut in sorted(cuts, key=lambda one: one.t):
        if not kept or cut.t - kept[-1].t > 1e-9:
            kept.append(cut)
    return kept


def _bracket(curve: Curve, cuts: Sequence[_Cut], t: float) -> tuple[_Cut | None, _Cut | None]:
    """The crossings before and behind a parameter; of a closed curve around its seam."""
    before = [one for one in cuts if one.t <= t]
    behind = [one for one in cuts if one.t > t]
    if curve.closed and cuts:
        return (before or [*cuts])[-1], (behind or [*cuts])[0]
    return (before[-1] if before else None), (behind[0] if behind else None)


def _span_by(
    session: Session, words: Words, target: Operand, curve: Curve, cutters: list[Operand]
) -> tuple[_Cut | None, _Cut | None]:
    """The stretch that `trim by` deletes."""
    if curve.closed:
        message = f"{target.handle} is closed: cutters bound two stretches of it"
        hint = f"point at the stretch: `trim {target.handle} x,y`"
        fail("E1282", message, target.token.span, "", hint)
    crossings = [_distinct(_crossings_with(session, target, curve, one)) for one in cutters]
    towards = next(iter(words.flags & {"forward", "backward"}), "")
    if towards:
        if len(cutters) > 1:
            message = f"`{towards}` goes from one cutter, found {len(cutters)}"
            fail("E1281", message, cutters[1].token.span, "", "leave the others out")
        to_high = (towards == "forward") != target.entity.clockwise
        return (crossings[0][-1], None) if to_high else (None, crossings[0][0])
    if len(cutters) > 2:
        message = f"`trim ... by` takes one or two cutters, found {len(cutters)}"
        fail("E1281", message, cutters[2].token.span, "", "point at the stretch with a coordinate")
    if len(cutters) == 1:
        if len(crossings[0]) == 2:
            return crossings[0][0], crossings[0][1]
        message = f"{cutters[0].handle} crosses {target.handle} {_times(len(crossings[0]))}"
        hint = "append `forward` or `backward`, or name a second cutter"
        fail("E1281", message, cutters[0].token.span, "", hint)
    low, high = min(
        (sorted((a, b)) for a in crossings[0] for b in crossings[1]),
        key=lambda pair: pair[1].t - pair[0].t,
    )
    if not high.t - low.t > 1e-9:
        message = f"{cutters[0].handle} and {cutters[1].handle} cross {target.handle} at one place"
        fail("E1281", message, cutters[1].token.span, "", "append `forward` or `backward`")
    return low, high


def _times(count: int) -> str:
    return {1: "once", 2: "twice"}.get(count, f"{count} times")


def _nothing_crosses(target: Operand, token: Token) -> None:
    message = f"nothing crosses {target.handle}: there is no place to cut it"
    fail("E1281", message, token.span, "", "draw what is to cut it first")


def _too_few(target: Operand) -> None:
    message = f"{target.handle} is closed: it is cut at two crossings at least"
    fail("E1282", message, target.token.span, "", "draw a second curve that crosses it")


def _deleted_whole(session: Session, target: Entity) -> Reply:
    gone = session.editor.delete([target.name])
    cascade = [name for name in gone.names if name != target.name]
    lines = [f"Trimmed {target.name}: nothing crosses it, deleted"]
    lines += [f"  dropped: {', '.join(cascade)}"] if cascade else []
    return Reply("\n".join(lines), data={"deleted": list(gone.names), "pieces": []})


def _cut(
    session: Session,
    words: Words,
    target: Entity,
    curve: Curve,
    cuts: list[_Cut],
    span: tuple[_Cut | None, _Cut | None] | None,
) -> Reply:
    """Cut at places, delete the stretch between `span`, carry over what refers to the target."""
    document = session.document
    with document.transaction(words.statement.text), placed_at(words):
        parts = []
        pieces = curve.split(*(cut.t for cut in cuts))
        for piece in reversed(pieces) if target.clockwise else pieces:
            if span is not None and _inside(curve, span, 0.5 * (piece.start + piece.end)):
                continue
            kind, numbers = numbers_of(piece.curve)
            entity = document.add_entity(
                kind,
                numbers,
                construction=target.construction,
                quiet=target.quiet,
                style=target.style,
                clockwise=target.clockwise,
            )
            parts.append(Part(entity, piece.start, piece.end))
        division = Division(document, target, curve, tuple(parts), span is None)
        done = carry(session.editor, division)
        unpinned = [] if "nopin" in words.flags else _pin(session, division, cuts, done)
    return _reply(session, words, target, division, done, unpinned)


def _inside(curve: Curve, span: tuple[_Cut | None, _Cut | None], t: float) -> bool:
    low = span[0].t if span[0] else 0.0
    high = span[1].t if span[1] else 1.0
    if curve.closed and high <= low:
        high += 1.0
    return low < t < high or (curve.closed and (low < t + 1.0 < high or low < t - 1.0 < high))


def _pin(session: Session, division: Division, cuts: Sequence[_Cut], done: Transfer) -> list[str]:
    """Hold cut ends on their cutters: of connected ends one; what does not go, in words."""
    said: list[str] = []
    for cut in cuts:
        handles = []
        for part in division.parts:
            for t, end in ((part.start, low_end), (part.end, high_end)):
                off = abs(t - cut.t)
                if off < 1e-9 or (division.curve.closed and abs(off - 1.0) < 1e-9):
                    handles.append(f"{part.entity.name}.{end(part.entity)}")
        if not handles:
            continue
        args = (handles[0], cut.cutter)
        try:
            with session.document.transaction("pin"):
                done.added.append(session.editor.constrain("point_on", args).name)
        except AraelError as error:
            said.append(f"{' on '.join(args)}: {error.diagnostics[0].message}")
    return said


def _reply(
    session: Session,
    words: Words,
    target: Entity,
    division: Division,
    done: Transfer,
    unpinned: list[str],
) -> Reply:
    document = session.document
    names = tuple(part.entity.name for part in division.parts)
    verb = "Split" if division.whole else "Trimmed"
    lines = [f"{verb} {target.name} -> {' '.join(names)}"]
    lines += [f"  {entity_line(document, document.entities[name])}" for name in names]
    lines += report_lines(session, done)
    lines += [f"  not pinned: {one}" for one in unpinned]
    data = {"entity": target.name, "pieces": list(names), "unpinned": unpinned, **done.data}
    return Reply("\n".join(lines), names, data=data)


def report_lines(session: Session, done: Transfer) -> list[str]:
    """What a transfer did, for people: one line per record."""
    document = session.document

    def line(name: str) -> str:
        record = document.find(name)
        return record_line(session, record) if record is not None else name

    lines = [f"  added: {line(name)}" for name in done.added]
    for name, before in done.moved.items():
        was = f" (was {before})" if before != name else ""
        lines.append(f"  moved: {line(name)}{was}")
    lines += [f"  copied: {line(name)} (from {source})" for name, source in done.copied.items()]
    lines += [f"  implied: {text}" for text in done.implied]
    lines += [f"  dropped: {name}: {text}" for name, text in done.dropped.items()]
    lines += [f"  rewritten: {line(name)}" for name in done.rewritten]
    lines += [f"  dissolved: {name}" for name in done.dissolved]
    lines += [f"  broken: {', '.join(done.broken)}"] if done.broken else []
    return lines
