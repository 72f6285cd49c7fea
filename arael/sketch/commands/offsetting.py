"""`offset_line`: a parallel line at a distance."""

from __future__ import annotations

import math

from arael.sketch.commands.creating import placed_at
from arael.sketch.commands.describing import entity_line
from arael.sketch.commands.reading import Words
from arael.sketch.commands.replies import Reply
from arael.sketch.commands.session import Session
from arael.sketch.commands.table import command
from arael.sketch.commands.tokens import fail
from arael.sketch.document.records import Amount, Group
from arael.sketch.groups.copies import center_of, names_of, owned_since


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
