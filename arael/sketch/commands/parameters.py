"""Commands on parameters."""

from __future__ import annotations

from dataclasses import replace

from arael.diagnostics.records import AraelError, Source, Span
from arael.diagnostics.suggest import closest
from arael.sketch.commands.numbers import shown
from arael.sketch.commands.reading import Words
from arael.sketch.commands.replies import Reply
from arael.sketch.commands.session import Session
from arael.sketch.commands.table import command
from arael.sketch.commands.tokens import Token, fail
from arael.sketch.document.handles import split_handle
from arael.sketch.document.kinds import PREFIXES
from arael.sketch.document.records import Parameter
from arael.sketch.expressions.dependencies import cycle_through, readers
from arael.sketch.expressions.functions import CONSTANTS, GEOMETRY, scalar_functions
from arael.sketch.expressions.renaming import rename_everywhere
from arael.syntax import tree
from arael.syntax.parser import parse_expression


def require_no_cycle(session: Session, name: str, texts: list[str], span: Span) -> None:
    """E1240 if a parameter or dimension with these expressions would read itself."""
    way = cycle_through(session.document, name, texts)
    if way:
        hint = f"give `{way[-2] if len(way) > 2 else name}` a number first"
        fail("E1240", f"`{name}` would read itself: {' -> '.join(way[:8])}", span, "", hint)


def require_name(session: Session, token: Token) -> str:
    """The name of a new parameter; E1255 if it cannot be one."""
    name = token.text
    reason = ""
    if not name.isidentifier() or not name.isascii() or len(name) > 100:
        reason = "a name has letters, digits and `_`, and begins with no digit"
    elif split_handle(name) is not None and name.rstrip("0123456789") in PREFIXES:
        reason = "it is a name of entities, constraints and dimensions"
    elif name in CONSTANTS or name in GEOMETRY or name in scalar_functions():
        reason = "it has a meaning of its own"
    elif name.startswith("_") or name in ("cursor", "selection", "all") or not _is_word(name):
        reason = "it is a reserved word"
    elif session.variable(name) is not None:
        reason = "there is a variable of this name"
    elif session.document.find(name) is not None:
        reason = "something in the sketch has this name"
    if reason:
        message = f"`{name[:60]}` cannot be a parameter: {reason}"
        fail("E1255", message, token.span, "", "choose another name")
    return name


def _is_word(name: str) -> bool:
    try:
        return isinstance(parse_expression(Source("name", name)), tree.Name)
    except AraelError:
        return False


def parameter_of(session: Session, words: Words) -> tuple[Parameter, Token]:
    """Take the name of a parameter; E1256 if there is none of this name."""
    token = words.next("a parameter")
    found = session.document.parameters.get(token.text)
    if found is None:
        near = closest(token.text, session.document.parameters)
        hint = f"did you mean `{near[0]}`?" if near else "`list params` shows them"
        fail("E1256", f"no parameter `{token.text[:60]}`", token.span, "", hint)
    return found, token


@command(
    "param",
    group="parameters",
    usage=["param width 10", "param height width * 2"],
    summary="Make a parameter, or give it another value.",
    details="""
Expressions of dimensions and other parameters read it by its name and follow it. `=` before the
value takes what the expression is now.
""",
    arguments=("name", "value"),
)
def param(session: Session, words: Words) -> Reply:
    """Make or change a parameter."""
    token = words.next("a name")
    known = token.text in session.document.parameters
    name = token.text if known else require_name(session, token)
    value = words.next("a value")
    written = words.canonical(value) if not value.text.startswith("=") else ""
    if written:
        require_no_cycle(session, name, [written], value.span)
    amount = words.amount("a value", token=value)
    words.end()
    made = session.editor.set_parameter(name, amount)
    what = "Updated" if known else "Added"
    return Reply(
        f"{what} {name} = {made.amount.text} ({shown(made.amount.number)})",
        remembered=False,
        data={"parameter": name, "value": made.amount.number},
    )


@command(
    "del_param",
    group="parameters",
    usage=["del_param width"],
    summary="Delete a parameter.",
    details="Expressions that read it keep their last value and are marked as broken.",
    arguments=("name",),
)
def del_param(session: Session, words: Words) -> Reply:
    """Delete a parameter."""
    found, _ = parameter_of(session, words)
    words.end()
    broken = readers(session.document, found.name)
    session.editor.delete([found.name])
    lines = [f"Deleted parameter {found.name}"]
    if broken:
        lines.append(f"  broken: {', '.join(broken)} (they keep their last value)")
    return Reply("\n".join(lines), remembered=False, data={"broken": broken})


@command(
    "rename_param",
    group="parameters",
    usage=["rename_param width w"],
    summary="Rename a parameter; expressions that read it follow.",
    arguments=("name", "new_name"),
)
def rename_param(session: Session, words: Words) -> Reply:
    """Rename a parameter."""
    found, _ = parameter_of(session, words)
    token = words.next("the new name")
    words.end()
    document = session.document
    if token.text in document.parameters:
        fail("E1255", f"there is a parameter `{token.text}` already", token.span)
    new = require_name(session, token)
    with document.transaction("rename"):
        document.rename("parameters", found.name, replace(found, name=new))
        changed = rename_everywhere(document, {found.name: new})
        session.editor.solve()
    also = f"; changed: {', '.join(changed)}" if changed else ""
    return Reply(
        f"Renamed {found.name} to {new}{also}",
        remembered=False,
        data={"parameter": new, "changed": changed},
    )
