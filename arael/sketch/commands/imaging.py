"""`image`: one entity as a turned or shifted copy of another."""

from __future__ import annotations

from arael.sketch.commands.creating import placed_at
from arael.sketch.commands.numbers import place, shown
from arael.sketch.commands.reading import Words
from arael.sketch.commands.replies import Reply
from arael.sketch.commands.session import Session
from arael.sketch.commands.table import command
from arael.sketch.commands.tokens import fail
from arael.sketch.groups.copies import sizes_of
from arael.sketch.groups.ties import points_of


@command(
    "image",
    group="constrain",
    usage=("image L0 L1 rotate ANGLE [about P0] [force]", "image L0 L1 shift dx,dy [force]"),
    summary="Hold an entity as a turned or shifted copy of another one of its kind.",
    details="""
Every point and size of the second is that of the first, turned by an angle in degrees about a point
(about 0,0 without one) or shifted. `pattern` makes whole sets of such copies.

```
add_line 0,0 4,0; add_line 10,1 14,1 noconnect
image L0 L1 shift 10,1
```
""",
    keywords=("force",),
    arguments=("source", "copy", "*words"),
)
def image(session: Session, words: Words) -> Reply:
    """Hold a copy to its source."""
    source, copy = words.operand("an entity", "entity"), words.operand("its copy", "entity")
    if (source.entity.kind, source.entity.size) != (copy.entity.kind, copy.entity.size):
        message = f"`{copy.handle}` is not of the kind of `{source.handle}`, {source.entity.kind}"
        fail("E1256", message, copy.token.span)
    args: tuple[str, ...] = (source.handle, copy.handle)
    if words.choice("`rotate` or `shift`", "rotate", "shift") == "rotate":
        angle = words.number("an angle in degrees", "angle")
        numbers = (angle, 0.0, 0.0)
        said = f"rotate {shown(angle)}"
        if words.accept("about"):
            center = words.operand("a point", "point").handle
            args = (*args, center)
            said += f" about {center}"
    else:
        by = words.point("the shift")
        numbers = (0.0, by.x, by.y)
        said = f"shift {place(by.x, by.y)}"
    words.end()
    mode = " ".join([*points_of(source.entity), *sizes_of(source.entity)])
    with placed_at(words):
        made = session.editor.constrain(
            "image", args, numbers=numbers, mode=mode, force="force" in words.flags
        )
    return Reply(
        f"Added {made.name}: image {source.handle} -> {copy.handle} {said}",
        (made.name,),
        remembered=False,
    )
