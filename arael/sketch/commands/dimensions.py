"""Commands that make and change dimensions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

from arael.diagnostics.records import AraelError
from arael.diagnostics.suggest import closest
from arael.sketch.commands.describing import dimension_line, noticed
from arael.sketch.commands.numbers import shown
from arael.sketch.commands.parameters import require_no_cycle
from arael.sketch.commands.reading import Operand, Words
from arael.sketch.commands.replies import Reply
from arael.sketch.commands.session import Session
from arael.sketch.commands.table import command
from arael.sketch.commands.tokens import Token, fail
from arael.sketch.document.kinds import DIMENSIONS
from arael.sketch.document.records import Amount, Dimension

_MODES = ("supplement", "closest", "acute", "obtuse")


class _Kind(NamedTuple):
    usage: tuple[str, ...]
    summary: str
    operands: tuple[str, ...]
    details: str = ""


_KINDS = {
    "length": _Kind(("length L0 VALUE",), "Length of a line.", ("a line",)),
    "distance": _Kind(
        (
            "distance L0.p1 L1.p2 VALUE",
            "distance P0 L0 VALUE",
            "distance L0 L1 VALUE",
            "distance A0 A1 VALUE",
            "distance L0 A0 VALUE",
            "distance P0 A0 VALUE",
        ),
        "Distance of two points, lines or circles, or of one and another.",
        ("an entity or point", "another entity or point"),
        """
Lines stay parallel as long as the distance is there, without a constraint that would be left. Of
circles and arcs it is that from edge to edge, of whole circles: between two that lie side by side
(`outside`), one in the other (`inside`), or around one centre, which they then keep. Circles that
cross are brought to the nearer of these. A point stays inside or outside, a line on its side.
With a negative value a point, or a circle, is to the right of a line (from p1 to p2), the second of
two lines to the right of the first, a point inside a circle, the second of two circles around one
centre the smaller. Other distances have no sign.
""",
    ),
    "hdistance": _Kind(
        ("hdistance L0.p1 L1.p2 VALUE",),
        "Distance of two points along x; which is on the left stays.",
        ("a point", "another point"),
        """
With a negative value the second point is to the left of the first.
""",
    ),
    "vdistance": _Kind(
        ("vdistance L0.p1 L1.p2 VALUE",),
        "Distance of two points along y; which is above stays.",
        ("a point", "another point"),
        """
With a negative value the second point is below the first.
""",
    ),
    "radius": _Kind(
        ("radius A0 VALUE",), "Radius of a circle or arc; first radius of an ellipse.", ("an arc",)
    ),
    "diameter": _Kind(("diameter A0 VALUE",), "Diameter of a circle or arc.", ("an arc",)),
    "radius_b": _Kind(("radius_b EA0 VALUE",), "Second radius of an ellipse.", ("an ellipse",)),
    "sweep": _Kind(("sweep A0 VALUE",), "Angle of an arc from start to end.", ("an arc",)),
    "arc_length": _Kind(("arc_length A0 VALUE",), "Length along an arc.", ("an arc",)),
    "angle": _Kind(
        ("angle L0 L1 VALUE [supplement] [closest] [acute] [obtuse]",),
        "Angle between the directions of two lines.",
        ("a line", "another line"),
        """
Directions run from p1 to p2; a negative value is clockwise. `supplement` means the other angle,
180 minus this one; `closest` the one of the two that is closer to the value, `acute` the smaller,
`obtuse` the larger one as the lines lie now.
""",
    ),
    "xangle": _Kind(
        ("xangle L0 VALUE", "xangle EA0 VALUE"),
        "Angle of a line or of an ellipse's major axis from the x axis, counter-clockwise.",
        ("a line or ellipse",),
    ),
    "total_length": _Kind(
        ("total_length L0 L1 A0 VALUE",), "Length of a chain of curves.", ("a curve", "*")
    ),
    "area": _Kind(
        ("area L0 L1 L2 VALUE",), "Area inside of a closed chain of curves.", ("a curve", "*")
    ),
}

_VALUES = """
VALUE is a number (`5`, `12 mm`, `0.5 in`, `30 deg`), a live expression that is followed
(`width/2`, `L0.length`), a snapshot of one (`=width/2`), or a range (`>= 2`, `<= 10`, `2 to 5`;
where a negative value means a side, also `-5 to -2`).
`derived` only measures; `driven` holds the value that it has now. One that is there already gets
the new value. `force` lets in a redundant one.
"""


class _Value(NamedTuple):
    value: Amount | None = None
    low: Amount | None = None
    high: Amount | None = None

    @property
    def amounts(self) -> list[Amount]:
        return [one for one in self if one is not None]


def _read_value(words: Words, quantity: str) -> _Value:
    """A value or a range; all None if there is no word left."""
    what = "an angle in degrees" if quantity == "angle" else "a number"
    sign = words.accept(">=", "<=")
    if sign:
        bound = words.amount("a bound", quantity)
        return _Value(low=bound) if sign == ">=" else _Value(high=bound)
    if not words:
        return _Value()
    first = words.amount(what, quantity)
    if words.accept("to"):
        return _Value(low=first, high=words.amount("an upper bound", quantity))
    return _Value(value=first)


def _operands(words: Words, kind: str) -> list[Operand]:
    wanted = _KINDS[kind].operands
    if "*" not in wanted:
        return [words.operand(what) for what in wanted]
    found = [words.operand(wanted[0])]
    while words and words.find(words.items[0]) is not None:
        found.append(words.operand(wanted[0]))
    return found


def _dimension(kind: str) -> Callable[[Session, Words], Reply]:
    quantity = DIMENSIONS[kind].quantity

    def run(session: Session, words: Words) -> Reply:
        flags = words.flags
        words.refuse_together("derived", "driven")
        words.refuse_together(*_MODES)
        args = tuple(one.handle for one in _operands(words, kind))
        first = words.peek()
        given = _read_value(words, quantity)
        words.end()
        _check(words, given, first)
        mode = next((word for word in _MODES if word in flags), "")
        known = session.editor.known_dimension(kind, args)
        if first is not None and known is not None:
            texts = [amount.text for amount in given.amounts]
            require_no_cycle(session, known.name, texts, first.span)
        made = session.editor.dimension(
            kind,
            args,
            value=given.value,
            low=given.low,
            high=given.high,
            derived="derived" in flags,
            mode=mode,
            force="force" in flags,
        )
        if known is None or known.name != made.name:
            return _reply(session, made, "Added")
        return updated(session, known, made)

    run.__name__ = kind
    run.__doc__ = _KINDS[kind].summary
    return run


def _check(words: Words, given: _Value, first: Token | None) -> None:
    flags = words.flags
    is_range = given.low is not None or given.high is not None
    if first is None and not flags & {"derived", "driven"}:
        words.missing("a value, `derived` or `driven`")
    if first is not None and "driven" in flags:
        hint = "`driven` takes the value that it has now: leave one of the two out"
        fail("E1267", "`driven` with a value", first.span, "", hint)
    chosen = sorted(flags & {"closest", "acute", "obtuse"})
    if is_range and chosen and first is not None:
        hint = "write `supplement` for the other angle, or nothing"
        fail("E1271", f"`{chosen[0]}` needs one value, not a range", first.span, "", hint)
    if is_range and "derived" in flags and first is not None:
        fail("E1271", "a derived dimension only measures: it has no range", first.span)


def updated(session: Session, known: Dimension, made: Dimension) -> Reply:
    """Reply to a value of a dimension that was there: a new one, or that which it had."""
    return _reply(session, made, "Unchanged" if made == known else "Updated")


def _reply(session: Session, made: Dimension, what: str) -> Reply:
    return Reply(
        noticed(session, f"{what} {dimension_line(session, made)}"),
        (made.name,),
        remembered=False,
        data={"dimensions": [made.name], "value": _number(session, made)},
    )


def _number(session: Session, dimension: Dimension) -> float:
    if dimension.value is not None and not dimension.derived:
        return dimension.value.number
    return float(session.editor.measure(dimension.kind, dimension.args, dimension.mode))


for _name, _one in _KINDS.items():
    command(
        _name,
        group="dimension",
        usage=[f"{line} [derived] [driven] [force]" for line in _one.usage],
        summary=_one.summary,
        details=f"{_one.details.strip()}\n{_VALUES}",
        keywords=("derived", "driven", "force", *(_MODES if _name == "angle" else ())),
        arguments=(
            ("*operands",)
            if "*" in _one.operands
            else (
                ("entity", "value=") if len(_one.operands) == 1 else ("first", "second", "value=")
            )
        ),
    )(_dimension(_name))


def dimension_of(session: Session, words: Words) -> Dimension:
    """Take the name of a dimension; E1256 if it is none."""
    token = words.next("a dimension (`d0`)")
    found = session.document.dimensions.get(session.resolve(token.text))
    if found is None:
        near = closest(token.text, session.document.dimensions)
        hint = f"did you mean `{near[0]}`?" if near else "`list dims` shows them"
        message = f"expected a dimension, found `{token.text[:60]}`"
        fail("E1256", message, token.span, "", hint)
    return found


@command(
    "set_derived",
    group="dimension",
    usage=["set_derived d0"],
    summary="Let a dimension only measure.",
    arguments=("dimension",),
)
def set_derived(session: Session, words: Words) -> Reply:
    """Let a dimension only measure."""
    found = dimension_of(session, words)
    words.end()
    now = float(session.editor.measure(found.kind, found.args, found.mode))
    changes: dict[str, Any] = {"derived": True, "low": None, "high": None, "broken": ""}
    changes["value"] = found.value or Amount(repr(now), now)
    made = session.editor.set_dimension(found.name, **changes)
    return updated(session, found, made)


@command(
    "set_driven",
    group="dimension",
    usage=["set_driven d0", "set_driven d0 VALUE"],
    summary="Let a dimension hold its quantity: at the present value, or at another one.",
    arguments=("dimension", "value="),
)
def set_driven(session: Session, words: Words) -> Reply:
    """Let a dimension hold its quantity."""
    found = dimension_of(session, words)
    first = words.peek()
    given = _read_value(words, DIMENSIONS[found.kind].quantity)
    words.end()
    if first is None:
        now = float(session.editor.measure(found.kind, found.args, found.mode))
        given = _Value(Amount(repr(now), now))
    else:
        texts = [amount.text for amount in given.amounts]
        require_no_cycle(session, found.name, texts, first.span)
    made = session.editor.set_dimension(found.name, derived=False, broken="", **given._asdict())
    return updated(session, found, made)


@command(
    "dim_pos",
    group="dimension",
    usage=["dim_pos d0 offset 1.5", "dim_pos d0 along 0.3", "dim_pos d0 offset @0.5"],
    summary="Place the text of a dimension: away from the geometry, or along it.",
    details="`along` runs from -0.5 to 0.5. A number behind `@` is added to the present one.",
    arguments=("dimension", "direction", "value"),
)
def dim_pos(session: Session, words: Words) -> Reply:
    """Place the text of a dimension."""
    found = dimension_of(session, words)
    which = words.choice("`offset` or `along`", "offset", "along")
    token = words.next("a number")
    relative = token.text.startswith("@")
    if relative:
        span = replace(token.span, start=token.span.start + 1)
        token = Token(token.text[1:], span)
    value = words.number_of(token, "a number", "length")
    words.end()
    now = found.offset if which == "offset" else found.along
    value += (now or 0.0) if relative else 0.0
    if which == "along":
        words.require_bounds(value, token, "`along`", least=-0.5, most=0.5)
    made = (
        session.editor.set_dimension(found.name, offset=value)
        if which == "offset"
        else session.editor.set_dimension(found.name, along=value)
    )
    return Reply(f"{made.name}: {which} {shown(value)}", remembered=False, data={which: value})


_FROZEN = {
    "line": ("length",),
    "circle": ("radius",),
    "arc": ("radius", "sweep"),
    "ellipse": ("radius", "radius_b"),
    "earc": ("radius", "radius_b"),
}


@command(
    "freeze",
    group="dimension",
    usage=["freeze", "freeze L0 A0 ..."],
    summary="Add dimensions at the present values to all lines and arcs, or to some.",
    details="""
Lines get a length, circles a radius, arcs a radius and a sweep. What has one already, and what
would be redundant, is left out and listed.
""",
    arguments=("*entities",),
)
def freeze(session: Session, words: Words) -> Reply:
    """Add dimensions at the present values."""
    document = session.document
    entities = (
        [one.entity for one in words.operands("a line or arc", "curve")]
        if words
        else list(document.entities.values())
    )
    words.end()
    made: list[str] = []
    left: list[str] = []
    for entity in entities:
        for kind in _FROZEN.get(entity.kind, ()):
            if session.editor.known_dimension(kind, (entity.name,)) is not None:
                continue
            try:
                made.append(session.editor.dimension(kind, (entity.name,)).name)
            except AraelError as error:
                left.append(f"{kind} {entity.name}: {error.diagnostics[0].message}")
    lines = [f"Added {dimension_line(session, document.dimensions[name])}" for name in made]
    lines += [f"Left out {one}" for one in left]
    return Reply(
        "\n".join(lines) or "Nothing to freeze",
        tuple(made),
        remembered=False,
        data={"dimensions": made, "left": left},
    )
