"""`offset`: curves at a distance from a sequence; `offset_line`: a parallel line."""

from __future__ import annotations

import math
from dataclasses import replace

from arael.sketch.commands.creating import placed_at
from arael.sketch.commands.describing import amount_text, entity_line
from arael.sketch.commands.reading import Words
from arael.sketch.commands.replies import Reply
from arael.sketch.commands.selecting import sequence
from arael.sketch.commands.session import Session
from arael.sketch.commands.table import command
from arael.sketch.commands.tokens import Token, fail
from arael.sketch.document.records import Amount, Group
from arael.sketch.expressions.evaluation import number
from arael.sketch.geometry.chains import area
from arael.sketch.groups.copies import center_of, names_of, owned_since
from arael.sketch.groups.offsets import Made, Offset, chain_of, change, make, pins_of, results_of
from arael.sketch.groups.sequences import Chain, SequenceError, ordered

_WORDS = (
    *("left", "right", "flip", "symmetric", "two", "one", "inward", "outward"),
    *("round", "sharp", "caps", "pin", "nopin", "quiet", "constr"),
)


@command(
    "offset",
    group="modify",
    usage=(
        "offset L0 [L1 A0 ...] DISTANCE [DISTANCE2] [left] [right] [flip] [symmetric] [inward]"
        " [outward] [round] [sharp] [caps line|round|none] [nopin] [constr] [quiet]",
        "offset sequence L0 DISTANCE ...",
        "offset selection DISTANCE ...",
        "offset M0 [DISTANCE [DISTANCE2]] [one] [two] [flip] [round] [caps none] [pin] ...",
    ),
    summary="Curves at a distance from a sequence of curves, which follow it.",
    details="""
The curves are connected end to end; the direction is that of the first one, and the distance is to
the left of it: `right`, `flip` or a negative distance change that, `inward` and `outward` belong to
closed sequences, `symmetric` or a second distance make both sides. `sequence L0` takes everything
end to end with L0. Corners are sharp; with `round` those that the result goes round become arcs.
`caps line` and `caps round` close the ends of two sides. Free ends and tangent joints stay beside
those of the source, with `nopin` they slide. The offset takes no freedom and brings none.

One dimension has the distance, the others read it. An arc with a smaller radius than the distance
vanishes, and its neighbours meet. The offset of an ellipse is approximately the ellipse whose radii
differ by the distance; splines have none. `offset M0` with some of these words edits: curves are
moved, only sides with other corners are made again. Changing an owned dimension or deleting a part
dissolves the group; deleting a pin does not.

```
a, b = add_line 0,0 10,0 10,6
m = offset a b 2
offset m 3 round
offset m symmetric caps line
```
""",
    arguments=("*words",),
)
def offset(session: Session, words: Words) -> Reply:
    """Make or edit an offset."""
    token = words.peek()
    if token is None:
        words.missing("a line or arc, `sequence`, `selection` or an offset")
    group = session.document.groups.get(session.resolve(token.text))
    if group is None and token.text == "selection" and len(session.selection) == 1:
        group = session.document.groups.get(session.selection[0])
    if group is not None:
        words.next("")
        return _edit(session, words, group, token)
    chain = _chain(session, words)
    flags: set[str] = set()
    given = _read(session, words, Offset(Amount("0", 0.0)), chain, flags)
    if given.distance.number == 0.0:
        words.missing("the distance")
    with placed_at(words):
        made = make(session.editor, chain, given, "quiet" in flags, "constr" in flags)
    return _reply(session, made, "Added")


def _edit(session: Session, words: Words, group: Group, token: Token) -> Reply:
    if group.kind != "offset" or "shape" not in group.options:
        hint = "its dimension changes it" if group.kind == "offset" else ""
        message = f"{group.name} is of kind {group.kind}, not an offset of a sequence"
        fail("E1256", message, token.span, "", *([hint] if hint else []))
    if not words:
        words.missing("what to change")
    options = group.options

    def value(key: str) -> Amount | None:
        text = str(options[key])
        if not text:
            return None
        return Amount(text, number(text, session.scope))

    distance = value("distance")
    assert distance is not None
    given = Offset(
        distance,
        value("distance2"),
        str(options["form"]),
        int(options["side"]),  # type: ignore[arg-type]
        bool(options["round"]),
        str(options["caps"]),
        bool(options["pinned"]),
    )
    given = _read(session, words, given, chain_of(group), set())
    with placed_at(words):
        made = change(session.editor, group, given)
    return _reply(session, made, "Changed")


def _chain(session: Session, words: Words) -> Chain:
    """The sequence that is named."""
    document = session.document
    first = words.peek()
    assert first is not None
    if words.accept("sequence"):
        start = words.operand("a line or arc", "curve").handle
        names = sequence(document, start)
        # in the direction of the one that was named
        names.remove(start)
        names.insert(0, start)
    else:
        found = words.operands("a line or arc", "curve")
        names = list(dict.fromkeys(one.entity.name for one in found))
    try:
        return ordered(document, names)
    except SequenceError as error:
        hint = "`select L0 sequence` shows what is end to end with L0"
        fail("E1256", f"these are not one sequence: {error}", first.span, "", hint)


def _read(session: Session, words: Words, given: Offset, chain: Chain, flags: set[str]) -> Offset:
    """The distances and words behind the curves."""
    values: list[Amount] = []
    form = caps = ""
    while words:
        token = words.items[0]
        if token.text not in _WORDS:
            if len(values) == 2:
                fail("E1252", f"`{token.text[:60]}` is not expected here", token.span)
            amount = words.amount("a distance or a word of offsets", "length")
            if amount.number == 0.0:
                fail("E1257", "the distance of an offset is not 0", token.span)
            values.append(amount)
            continue
        word = words.next("").text
        if word in ("symmetric", "two", "one"):
            form = word
            given = replace(given, form=word)
        elif word == "caps":
            caps = words.choice("a kind of caps", "line", "round", "none")
            given = replace(given, caps=caps)
        elif word in ("quiet", "constr"):
            flags.add(word)
        elif word in ("round", "sharp"):
            given = replace(given, rounded=word == "round")
        elif word in ("pin", "nopin"):
            given = replace(given, pinned=word == "pin")
        else:
            given = replace(given, side=_side(session, given, chain, word, token))
    if values and values[0].number < 0.0:
        values = [_negated(values[0]), *values[1:]]
        given = replace(given, side=-given.side)
    if any(one.number < 0.0 for one in values):
        fail("E1257", "the second distance is positive, on the other side", words.statement.span)
    if values:
        given = replace(given, distance=values[0])
    if len(values) == 2:
        given = replace(given, distance2=values[1], form=form or "two")
    if given.form != "two":
        given = replace(given, distance2=None)
    elif given.distance2 is None:
        given = replace(given, distance2=given.distance)
    if given.form == "one" and not caps:
        given = replace(given, caps="none")
    return given


def _negated(amount: Amount) -> Amount:
    return Amount(f"-({amount.text})", -amount.number)


def _side(session: Session, given: Offset, chain: Chain, word: str, token: Token) -> int:
    if word in ("left", "right"):
        return 1 if word == "left" else -1
    if word == "flip":
        return -given.side
    if not chain.closed:
        message = f"`{word}` belongs to a closed sequence, and this one is open"
        fail("E1256", message, token.span, "", "write `left` or `right`")
    # counter-clockwise, the inside is on the left
    left = 1 if area(chain.curves(session.document)) > 0.0 else -1
    return left if word == "inward" else -left


def _reply(session: Session, made: Made, what: str) -> Reply:
    group, document = made.group, session.document
    lines = [f"{what} {described(session, group)}"]
    shown_now = made.added if what == "Changed" else group.results
    lines += [f"  {entity_line(document, document.entities[name])}" for name in shown_now]
    if made.gone:
        lines.append(f"  deleted: {' '.join(made.gone)}")
    if what == "Added":
        held = [*(one for one in group.owned if one in document.constraints), *pins_of(group)]
        lines.append(f"  constraints: {' '.join(held)}")
    sizes = [one for one in group.owned if one in document.dimensions]
    lines.append(f"  dimensions: {' '.join(sizes)}")
    vanished = dict.fromkeys(group.sources[i] for side in made.sides for i in side.vanished)
    if vanished:
        lines.append(
            f"  vanished: {' '.join(vanished)} (a smaller radius than the distance; the neighbours "
            "meet)"
        )
    if made.approximate:
        lines.append(
            "  approximate: the offset of an ellipse is no ellipse; radii differ by the distance"
        )
    return Reply(
        "\n".join(lines),
        group.results,
        group.name,
        data={
            "group": group.name,
            "entities": list(group.results),
            "owned": list(group.owned),
            "added": list(made.added),
            "deleted": list(made.gone),
            "vanished": list(vanished),
            "approximate": made.approximate,
        },
    )


def described(session: Session, group: Group) -> str:
    """``M0: offset of L0 L1 by 2 left: L2 L3``."""
    options = group.options
    first, second, caps = results_of(group)
    sides = ("left", "right") if options["side"] == 1 else ("right", "left")
    amounts = [
        Amount(text, number(text, session.scope))
        for text in (str(options["distance"]), str(options["distance2"]))
        if text
    ]
    texts = [amount_text(one) for one in amounts]
    by = f"{texts[0]} {'symmetric' if options['form'] == 'symmetric' else sides[0]}"
    if len(texts) > 1:
        by += f", {texts[1]} {sides[1]}"
    closed = " (closed)" if options["closed"] else ""
    head = f"{group.name}: offset of {' '.join(group.sources)}{closed} by {by}"
    parts = [f"{sides[0]} {' '.join(first)}"]
    parts += [f"{sides[1]} {' '.join(second)}"] if second else []
    parts += [f"caps {' '.join(caps)}"] if caps else []
    return f"{head}: {'; '.join(parts)}"


@command(
    "offset_line",
    group="modify",
    usage=("offset_line L0 DISTANCE [right] [nopin] [constr] [quiet]",),
    summary="A parallel line at a distance from a line, which follows it.",
    details="""
It is to the left of the direction from p1 to p2; `right`, or a negative distance, puts it on the
other side. Its ends are held beside those of the source, with `nopin` they slide. The distance is a
dimension.

```
add_line 0,0 5,0
offset_line L0 2
```
""",
    keywords=("left", "right", "nopin", "constr", "quiet"),
    arguments=("line", "distance"),
)
def offset_line(session: Session, words: Words) -> Reply:
    """A parallel line."""
    words.refuse_together("left", "right")
    line = words.operand("", "line").handle
    token = words.peek()
    amount = words.amount("the distance", "length")
    words.end()
    assert token is not None
    if amount.number == 0.0:
        fail("E1257", "the distance of an offset is not 0", token.span)
    shift = -amount.number if "right" in words.flags else amount.number
    if amount.number < 0.0:
        amount = Amount(f"-({amount.text})", -amount.number)
    document, editor = session.document, session.editor
    a, b = (center_of(document, f"{line}.{end}") for end in ("p1", "p2"))
    length = math.dist(a, b)
    u, v = -(b[1] - a[1]) / length * shift, (b[0] - a[0]) / length * shift
    before = names_of(document)
    with placed_at(words), editor.together():
        copy = editor.add(
            "line",
            (a[0] + u, a[1] + v, b[0] + u, b[1] + v),
            connect=False,
            construction="constr" in words.flags,
            quiet="quiet" in words.flags,
        ).entity.name
        editor.constrain("parallel", (line, copy))
        editor.dimension("distance", (line, copy), value=amount)
        if "nopin" not in words.flags:
            for end in ("p1", "p2"):
                editor.constrain("on_normal", (f"{copy}.{end}", f"{line}.{end}"))
    owned = owned_since(document, before)
    group = document.put(
        "groups",
        Group(
            document.next_name("M"), "offset", (line,), (copy,), owned, {"distance": amount.text}
        ),
    )
    return Reply(
        f"Added {group.name}: offset of {line}\n  {entity_line(document, document.entities[copy])}",
        (copy,),
        group.name,
        data={"group": group.name, "entities": [copy], "owned": list(owned)},
    )
