"""Texts: `add_text`, `set_text`."""

from __future__ import annotations

from dataclasses import replace
from math import cos, hypot, radians, sin

from arael.diagnostics.records import AraelError
from arael.sketch.commands import creating
from arael.sketch.commands.describing import entity_line, noticed
from arael.sketch.commands.numbers import place, shown
from arael.sketch.commands.reading import Operand, Words
from arael.sketch.commands.replies import Reply
from arael.sketch.commands.session import Session
from arael.sketch.commands.table import command
from arael.sketch.commands.tokens import Token, fail, quoted
from arael.sketch.document.texts import normalized, problem_of
from arael.sketch.expressions.vectors import Vec
from arael.sketch.text import unknown_characters, width_of

#: Height of a text by default: 3.5 mm (ISO 3098) in the units of sketches.
_HEIGHTS = {"mm": 3.5, "cm": 0.35, "m": 0.0035, "in": 0.14}


@command(
    "add_text",
    group="create",
    usage=('add_text x,y "the text" [height h] [angle a] [noconnect] [nocursor] [quiet] [constr]',),
    summary="A text, lettered along a line that is its frame.",
    details="""
The frame is a line like any other: `p1` is the left end of the base line, its direction that of the
text, its length the width of the text. It takes constraints and dimensions, and the lettering
follows it: a longer frame has a higher text. `height` is that of the capitals, 3.5 mm unless it is
given; `angle` is in degrees. The base line is drawn thin and dashed, with `quiet` not at all.

The font has single strokes: printable ASCII and `°±Ø×µäöüÄÖÜß`. Another character is drawn as a
box, and the reply lists it. `set_text` changes the text.

```
t = add_text 0,0 "Ø8 ±0.1" height 5
horizontal t
length t 40
```
""",
    keywords=creating.COMMON,
    arguments=("at", "text", "*words"),
)
def add_text(session: Session, words: Words) -> Reply:
    """A text."""
    at = words.point("the left end of the base line")
    text = _text(words)
    given: dict[str, float] = {}
    while words:
        token = words.peek()
        flag = words.accept(*creating.COMMON)
        if flag:
            words.flags.add(flag)
            continue
        word = words.choice("`height` or `angle`", "height", "angle")
        if word in given:
            assert token is not None
            fail("E1267", f"`{word}` is given twice", token.span)
        if word == "height":
            given[word] = words.number("the height of the text", "length", above=0.0)
        else:
            given[word] = words.number("the angle of the text", "angle")
    words.end()
    height = given.get("height", _HEIGHTS[session.document.unit])
    angle = radians(given.get("angle", 0.0))
    width = height * width_of(text)
    end = at.x + width * cos(angle), at.y + width * sin(angle)
    added = creating.add(session, words, "line", (at.x, at.y, *end), text=text)
    name = added.entity.name
    if "nocursor" not in words.flags:
        session.move_cursor(Vec(*end), chain=False)
    found = creating.reply(
        f"{name}: text {quoted(text)} at {place(at.x, at.y)}, height {shown(height)}, "
        f"width {shown(width)}",
        [added],
        [_boxed(text)],
    )
    more = {"text": text, "height": height, "unknown": unknown_characters(text)}
    return replace(found, data={**found.data, **more})


@command(
    "set_text",
    group="modify",
    usage=('set_text L0 "the text"', 'set_text L0 L1 ... "the text"'),
    summary="Change what texts read.",
    details="""
The height stays as long as the frame can take another length; a frame whose length is held keeps
it, and the height changes.

```
t = add_text 0,0 "first"
set_text t "second"
```
""",
    arguments=("*words",),
)
def set_text(session: Session, words: Words) -> Reply:
    """Change the text of frames."""
    frames: list[Operand] = []
    while words and not words.items[0].quoted:
        if frames and words.find(words.items[0]) is None:
            break  # a text without quotes
        frames.append(words.operand("a text", "line"))
        if not frames[-1].entity.text:
            message = f"{frames[-1].handle} is a line without a text"
            help_ = 'texts are made by `add_text 0,0 "the text"`'
            fail("E1256", message, frames[-1].token.span, "", help_)
    if not frames:
        words.missing("a text such as `L0`")
    text = _text(words)
    words.end()
    document = session.document
    with document.transaction(words.statement.text), creating.placed_at(words):
        for one in frames:
            _change(session, one.handle, text)
    names = list(dict.fromkeys(one.handle for one in frames))
    lines = [entity_line(document, document.entities[name]) for name in names]
    return Reply(
        noticed(session, "\n".join(lines) + _boxed(text)),
        remembered=False,
        data={"entities": names, "text": text, "unknown": unknown_characters(text)},
    )


class _HeldError(Exception):
    """The length of a frame is held."""


def _change(session: Session, name: str, text: str) -> None:
    """Set the text of a frame, and its length so that the height stays if that is possible."""
    document = session.document
    entity = document.entities[name]
    x1, y1, x2, y2 = document.numbers_of(name).tolist()
    factor = width_of(text) / width_of(entity.text)
    session.editor.change_entity(name, text=text)
    wanted = factor * hypot(x2 - x1, y2 - y1)
    try:
        with document.transaction("set_text"):
            end = x1 + factor * (x2 - x1), y1 + factor * (y2 - y1)
            session.editor.place([entity.at + 2, entity.at + 3], end)
            x1, y1, x2, y2 = document.numbers_of(name).tolist()
            if abs(hypot(x2 - x1, y2 - y1) - wanted) > 1e-6 * wanted:
                raise _HeldError
    except (AraelError, _HeldError):
        if session.editor.solver.interrupted:
            raise
        # everything is where it was: the frame keeps its length


def _text(words: Words) -> str:
    token = words.next('the text in quotes: `"the text"`')
    if not token.quoted:
        message = f"expected the text in quotes, found `{token.text[:60]}`"
        fail("E1252", message, token.span, "", f'write `"{token.text[:60]}"`')
    return _checked(token)


def _checked(token: Token) -> str:
    text = normalized(token.text)
    problem = problem_of(text)
    if problem:
        fail("E1285", problem, token.span)
    return text


def _boxed(text: str) -> str:
    """What the reply adds about characters that the font does not have."""
    unknown = unknown_characters(text)
    if not unknown:
        return ""
    listed = ", ".join(f"U+{ord(one):04X}" for one in unknown[:8])
    more = f" and {len(unknown) - 8} more" if len(unknown) > 8 else ""
    return f" [drawn as a box: {listed}{more}]"
