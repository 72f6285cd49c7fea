"""`switch_off` and `switch_on`: constraints and dimensions that stay listed and do not act."""

from __future__ import annotations

from collections.abc import Callable

from arael.diagnostics.suggest import closest
from arael.sketch.commands.describing import record_line
from arael.sketch.commands.reading import Words
from arael.sketch.commands.replies import Reply
from arael.sketch.commands.session import Session
from arael.sketch.commands.table import command
from arael.sketch.commands.tokens import fail


def _relations(session: Session, words: Words) -> list[str]:
    """Take names of constraints and dimensions."""
    document = session.document
    if not words:
        words.missing("a constraint or dimension, such as `C3` or `d0`")
    found: list[str] = []
    while words:
        token = words.next("")
        name = session.resolve(token.text)
        if name not in document.constraints and name not in document.dimensions:
            known = document.find(name) is not None
            message = f"`{token.text[:60]}` is no constraint or dimension"
            if not known:
                message = f"nothing in the sketch is called `{token.text[:60]}`"
            near = closest(name, [*document.constraints, *document.dimensions])
            hint = "`list constraints` and `list dims` show what there is"
            hint = f"did you mean `{near[0]}`?" if near and not known else hint
            fail("E1256" if known else "E1201", message, token.span, "", hint)
        found.append(name)
    return list(dict.fromkeys(found))


def _switch(active: bool) -> Callable[[Session, Words], Reply]:
    def run(session: Session, words: Words) -> Reply:
        names = _relations(session, words)
        document, editor = session.document, session.editor
        with document.transaction(words.statement.text):
            for name in names:
                if name in document.constraints:
                    if document.constraints[name].active != active:
                        editor.change_constraint(name, active=active)
                elif document.dimensions[name].active != active:
                    editor.set_dimension(name, active=active)
        found = [document.find(name) for name in names]
        lines = [record_line(session, one) for one in found if one is not None]
        return Reply("\n".join(lines), remembered=False, data={"active": active, "names": names})

    return run


command(
    "switch_off",
    group="constrain",
    usage="switch_off C3 [d0 ...]",
    summary="Let constraints and dimensions not act; they stay listed.",
    details="""
```
add_line 0,0 5,1
horizontal L0
switch_off CL0H
```
""",
    arguments=("*names",),
)(_switch(False))

command(
    "switch_on",
    group="constrain",
    usage="switch_on C3 [d0 ...]",
    summary="Let constraints and dimensions act again that were switched off.",
    details="""
One that has become redundant or impossible meanwhile is refused, and stays off.
""",
    arguments=("*names",),
)(_switch(True))
