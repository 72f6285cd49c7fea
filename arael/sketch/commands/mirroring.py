"""`mirror`."""

from __future__ import annotations

from arael.diagnostics.records import AraelError
from arael.sketch.commands.creating import placed_at
from arael.sketch.commands.describing import entity_line
from arael.sketch.commands.reading import Words, placed
from arael.sketch.commands.replies import Reply
from arael.sketch.commands.session import Session
from arael.sketch.commands.table import command
from arael.sketch.commands.tokens import fail
from arael.sketch.geometry.affine import Affine
from arael.sketch.groups.copies import center_of, copied, held_as_mirrored, names_of, owned_since


@command(
    "mirror",
    group="modify",
    usage=("mirror L0 [A0 P0 ...] about L1 [noconstraint] [strict]", "mirror selection about L1"),
    summary="Mirrored copies of entities about a line.",
    details="""
Every place of the set is held to its image by one symmetry, and the copies have the coincidences of
their sources. A text is not written backwards: the copy of its frame runs from left to right.
`noconstraint` makes plain geometry; `strict` takes everything back if the copies
cannot be held, otherwise they stay without constraints and the reason is shown.

```
a = add_line 0,0 3,1
axis = add_line 4,0 4,5
b = mirror a about axis
```
""",
    keywords=("noconstraint", "strict"),
    arguments=("*names",),
)
def mirror(session: Session, words: Words) -> Reply:
    """Mirror entities."""
    words.refuse_together("noconstraint", "strict")
    marked = bool(words.items) and words.items[0].text == "selection"
    found = words.operands("an entity", "entity")
    words.choice("`about`", "about")
    axis = words.operand("", "line")
    words.end()
    names = list(dict.fromkeys(one.entity.name for one in found))
    if axis.handle in names and marked:
        names.remove(axis.handle)
    if axis.handle in names or not names:
        fail("E1256", f"the axis {axis.handle} is in the set to mirror", axis.token.span)
    document, editor = session.document, session.editor
    by = Affine.mirror(*(center_of(document, f"{axis.handle}.{end}") for end in ("p1", "p2")))
    before = names_of(document)
    notes: list[str] = []
    copies: dict[str, str] = {}
    if "noconstraint" in words.flags:
        with placed_at(words):
            copies = copied(editor, names, by)
    else:
        try:
            with editor.together():
                copies = copied(editor, names, by)
                held_as_mirrored(editor, names, copies, axis.handle)
        except AraelError as error:
            if "strict" in words.flags:
                raise placed(error, words.span) from None
            copies = copied(editor, names, by)
            notes = [f"  without constraints: {error.diagnostics[0].message}"]
    new = owned_since(document, before)
    text = [entity_line(document, document.entities[copy]) for copy in copies.values()]
    if new:
        notes.append(f"  constraints: {' '.join(new)}")
    return Reply(
        "\n".join([f"Mirrored about {axis.handle}:", *(f"  {one}" for one in text), *notes]),
        tuple(copies.values()),
        data={"entities": list(copies.values()), "constraints": list(new)},
    )
