"""`pattern`: circular and rectangular copies."""

from __future__ import annotations

from dataclasses import replace

from arael.sketch.commands.creating import placed_at
from arael.sketch.commands.describing import entity_line
from arael.sketch.commands.numbers import shown
from arael.sketch.commands.reading import Words
from arael.sketch.commands.replies import Reply
from arael.sketch.commands.session import Session
from arael.sketch.commands.table import command
from arael.sketch.commands.tokens import Token, fail
from arael.sketch.document.records import Group
from arael.sketch.expressions.dependencies import paths_of
from arael.sketch.expressions.reading import literal
from arael.sketch.groups.patterns import Pattern, change, make

_MOST = 10_000


@command(
    "pattern",
    group="modify",
    usage=(
        "pattern circular L0 [A0 ...] about P0 N [full] [partial ANGLE] [symmetric ANGLE]",
        "pattern rect L0 [A0 ...] N DISTANCE [symmetric] [by N DISTANCE [symmetric]]"
        " [extent] [spacing] [along L5] [noalong] [one]",
        "pattern M0 ...",
    ),
    summary="Rigid copies in a circle or in a grid, which follow their sources.",
    details="""
N counts the source. `partial` spans an angle from the source (negative: clockwise), `symmetric` one
with the source in the middle. Distances of a grid are steps, with `extent` from the first to the
last instance; `along` takes axis 1 along a line and axis 2 to its left. `symmetric` behind an axis
puts instances on both sides, `one` on one side. Distances and angles follow parameters and
dimensions that they read; N is what it is at the command. `pattern M0` with some of these words
edits: copies of cells that stay are kept with all that is attached to them. `delete M0` keeps the
copies, `delete M0 all` deletes them.

```
add_line 2,0 3,0
m = pattern rect L0 3 10 by 2 5
pattern m 4 12
pattern m by 1 0
```
""",
    arguments=("*words",),
)
def pattern(session: Session, words: Words) -> Reply:
    """Make or edit a pattern."""
    token = words.peek()
    if token is not None:
        group = session.document.groups.get(session.resolve(token.text))
        if group is None and token.text == "selection" and len(session.selection) == 1:
            group = session.document.groups.get(session.selection[0])
        if group is not None:
            words.next("")
            return _edit(session, words, group, token)
    form = words.choice("`circular`, `rect` or a pattern", "circular", "rect")
    first = words.peek()
    found = words.operands("an entity", "entity")
    sources = tuple(dict.fromkeys(one.entity.name for one in found))
    given = Pattern(form)
    if form == "circular":
        words.choice("`about`", "about")
        given = replace(given, about=_center(words))
        given = replace(given, count=words.whole("the number of instances", 2, _MOST))
    else:
        given = replace(given, count=words.whole("the number of instances", 1, _MOST))
        given = _distance(words, given)
    assert first is not None
    given = _options(words, given)
    _check(words, given, sources)
    with placed_at(words):
        group = make(session.editor, given, sources)
    lines = [entity_line(session.document, session.document.entities[n]) for n in group.results]
    return Reply(
        "\n".join([f"Added {described(group)}", *(f"  {line}" for line in lines)]),
        group.results,
        group.name,
        data={"group": group.name, "entities": list(group.results), "owned": list(group.owned)},
    )


def _center(words: Words) -> str:
    return words.operand("the centre, a point", "point").handle


def _edit(session: Session, words: Words, group: Group, token: Token) -> Reply:
    if group.kind != "pattern":
        fail("E1256", f"{group.name} is of kind {group.kind}, not a pattern", token.span)
    if not words:
        words.missing("what to change")
    given = _options(words, _head(words, Pattern.of(group.options)))
    _check(words, given, group.sources)
    with placed_at(words):
        new, added, gone = change(session.editor, group, given)
    lines = [f"Changed {described(new)}"]
    if added:
        lines.append(f"  added: {' '.join(added)}")
    if gone:
        lines.append(f"  deleted: {' '.join(gone)}")
    return Reply(
        "\n".join(lines),
        new.results,
        new.name,
        data={"group": new.name, "added": added, "deleted": gone},
    )


_KEYWORDS = (
    *("full", "partial", "symmetric", "about", "by", "along", "noalong"),
    *("extent", "spacing", "one"),
)


def _head(words: Words, given: Pattern) -> Pattern:
    """Numbers before the keywords of an edit: a quantity, a quantity and a distance, a distance."""
    leading: list[Token] = []
    while words and words.items[0].text not in _KEYWORDS:
        leading.append(words.next("a number"))
    if len(leading) > 2:
        fail("E1252", f"`{leading[2].text}` is not expected here", leading[2].span)
    if not leading:
        return given
    count = words.number_of(leading[0])
    if len(leading) == 1 and given.form == "rect" and count != int(count):
        return _distance(words, given, token=leading[0])
    if count != int(count) or not 1 <= count <= _MOST:
        fail("E1257", f"the number of instances is whole, found {shown(count)}", leading[0].span)
    given = replace(given, count=int(count))
    if len(leading) == 2:
        if given.form != "rect":
            fail("E1252", f"`{leading[1].text}` is not expected here", leading[1].span)
        given = _distance(words, given, token=leading[1])
    return given


def _live(words: Words, what: str, quantity: str, token: Token | None = None) -> tuple[float, str]:
    """A number and the expression that it follows, empty for a literal."""
    span = (token or words.peek() or words.statement).span
    amount = words.amount(what, quantity, token)
    if literal(amount.text) is not None:
        return amount.number, ""
    read = {path.partition(".")[0] for path in paths_of(amount.text)}
    geometry = sorted(read & words.session.document.entities.keys())
    if geometry:
        hint = "put `=` before it to take what it is now, or read a parameter or dimension"
        fail(
            "E1257", f"{what} of a pattern does not follow geometry: {geometry[0]}", span, "", hint
        )
    return amount.number, amount.text


def _distance(
    words: Words, given: Pattern, key: str = "distance", token: Token | None = None
) -> Pattern:
    value, text = _live(words, "the distance", "length", token)
    if key == "distance":
        return replace(given, distance=value, distance_text=text)
    return replace(given, distance2=value, distance2_text=text)


def _options(words: Words, given: Pattern) -> Pattern:
    axis = 1
    while words:
        if given.form == "circular":
            word = words.choice("a word of patterns", "full", "partial", "symmetric", "about")
            if word == "full":
                given = replace(given, spread="full", angle=360.0, angle_text="")
            elif word == "about":
                given = replace(given, about=_center(words))
            else:
                token = words.peek()
                value, text = _live(words, "the angle", "angle")
                assert token is not None
                words.require_bounds(value, token, "the angle", least=-360.0, most=360.0)
                given = replace(given, spread=word, angle=value, angle_text=text)
            continue
        word = words.choice(
            "a word of patterns",
            *("by", "along", "noalong", "extent", "spacing", "symmetric", "one"),
        )
        if word == "by":
            axis = 2
            count = words.whole("the number of instances", 1, _MOST)
            given = replace(given, count2=count)
            if words and words.items[0].text not in _KEYWORDS:
                given = _distance(words, given, "distance2")
        elif word == "along":
            given = replace(given, along=words.operand("", "line").handle)
        elif word == "noalong":
            given = replace(given, along="")
        elif word in ("extent", "spacing"):
            given = replace(given, extent=word == "extent")
        elif word == "symmetric":
            given = (
                replace(given, symmetric1=True) if axis == 1 else replace(given, symmetric2=True)
            )
        else:
            given = (
                replace(given, symmetric1=False) if axis == 1 else replace(given, symmetric2=False)
            )
    return given


def _check(words: Words, given: Pattern, sources: tuple[str, ...]) -> None:
    span = words.statement.span
    count = given.count if given.form == "circular" else max(given.count, given.count2)
    if count < 2:
        fail("E1257", "a pattern has at least 2 instances", span)
    if given.form == "circular" and given.angle == 0.0:
        fail("E1257", "the angle of a pattern is not 0", span)
    if given.form == "rect" and (
        (given.count > 1 and given.distance == 0.0) or (given.count2 > 1 and given.distance2 == 0.0)
    ):
        fail("E1257", "the distance of a pattern is not 0", span)
    if given.count * given.count2 > _MOST:
        fail("E1257", f"a pattern has at most {_MOST:,} instances", span)
    if given.reference and given.reference.partition(".")[0] in sources:
        _may_contain(given, span)


def _may_contain(given: Pattern, span: object) -> None:
    """A centre on a source is a point of it, which stays; a whole entity is refused."""
    if "." not in given.reference:
        what = "centre" if given.form == "circular" else "line of direction"
        fail("E1256", f"the {what} {given.reference} is in the set to copy", span)  # type: ignore[arg-type]


def described(group: Group) -> str:
    """``M0: pattern of L0: 3 at 10 by 2 at 5``."""
    one = Pattern.of(group.options)
    head = f"{group.name}: {one.form} pattern of {' '.join(group.sources)}"
    if one.form == "circular":
        spread = one.spread if one.spread == "full" else f"{one.spread} {shown(one.angle)} deg"
        return f"{head}: {one.count} about {one.about}, {spread}"
    text = f"{head}: {one.count} at {shown(one.distance)}{' symmetric' * one.symmetric1}"
    if one.count2 > 1:
        text += f" by {one.count2} at {shown(one.distance2)}{' symmetric' * one.symmetric2}"
    return text + (" extent" if one.extent else "") + (f" along {one.along}" if one.along else "")
