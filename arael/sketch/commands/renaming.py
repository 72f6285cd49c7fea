"""`rename`: other names of entities and dimensions."""

from __future__ import annotations

from collections.abc import Mapping

from arael.diagnostics.suggest import closest
from arael.sketch.commands.reading import Words
from arael.sketch.commands.replies import Reply
from arael.sketch.commands.session import Session
from arael.sketch.commands.table import command
from arael.sketch.commands.tokens import Token, fail
from arael.sketch.document.handles import can_name
from arael.sketch.document.kinds import ENTITIES
from arael.sketch.document.records import Dimension, Entity
from arael.sketch.expressions.functions import GEOMETRY, scalar_functions
from arael.sketch.transfer.naming import handle_under
from arael.sketch.transfer.naming import rename as rename_record


@command(
    "rename",
    group="modify",
    usage=["rename L0 base1", "rename d0 width1"],
    summary="Rename an entity or dimension; everything that refers to it follows.",
    details="""
A name is letters and a number: `bore1`. Constraints, dimensions, groups and expressions are kept:
`L0.length / 2` becomes `base1.length / 2`, and `CL0H` becomes `Cbase1H`. `rename_param` renames
parameters.
""",
    arguments=("name", "new_name"),
)
def rename(session: Session, words: Words) -> Reply:
    """Rename an entity or dimension."""
    record = _record(session, words.next("an entity or dimension"))
    token = words.next("the new name")
    words.end()
    document = session.document
    prefix = "d" if isinstance(record, Dimension) else ENTITIES[record.kind].prefix
    new = _free_name(session, token, prefix)
    with document.transaction(words.statement.text):
        document.take_name(new, prefix)
        names = rename_record(document, record, new)
    _follow(session, names)
    return Reply(
        f"Renamed {record.name} to {new}",
        remembered=False,
        data={"name": new, "renamed": names},
    )


def _record(session: Session, token: Token) -> Entity | Dimension:
    document = session.document
    name = session.resolve(token.text)
    found = document.entities.get(name) or document.dimensions.get(name)
    if found is not None:
        return found
    if name in document.parameters:
        hint = f"`rename_param {name} NEW` renames a parameter"
        fail("E1256", f"`{token.text[:60]}` is a parameter", token.span, "", hint)
    near = closest(name, [*document.entities, *document.dimensions])
    hint = f"did you mean `{near[0]}`?" if near else "`list` shows what there is"
    message = f"expected an entity or dimension, found `{token.text[:60]}`"
    fail("E1256", message, token.span, "", hint)


def _free_name(session: Session, token: Token, prefix: str) -> str:
    """The new name of a record of the kind with a prefix; E1255 if it cannot be one."""
    name = token.text
    reason = ""
    if session.document.find(name) is not None:
        reason = "something in the sketch has this name"
    elif session.variable(name) is not None:
        reason = "there is a variable of this name"
    elif name in GEOMETRY or name in scalar_functions():
        reason = "it has a meaning of its own"
    elif not can_name(name, prefix):
        reason = "it is letters and a number, and the letters are not those of another kind"
    if reason:
        message = f"`{name[:60]}` cannot be the new name: {reason}"
        fail("E1255", message, token.span, "", "choose another name, such as `base1`")
    return name


def _follow(session: Session, names: Mapping[str, str]) -> None:
    """Variables and the selection stand for the same things as before."""
    state = session.state
    for key, value in state.variables.items():
        if isinstance(value, str):
            state.variables[key] = handle_under(names, value)
    state.selection = dict.fromkeys(handle_under(names, one) for one in state.selection)
    state.last = tuple(handle_under(names, one) for one in state.last)
    state.main = handle_under(names, state.main)
