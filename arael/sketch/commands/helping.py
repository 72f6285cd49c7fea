"""Help, messages, switches, and leaving."""

from __future__ import annotations

from arael.diagnostics.suggest import closest
from arael.sketch.commands import manual, table
from arael.sketch.commands.reading import Words
from arael.sketch.commands.replies import Reply
from arael.sketch.commands.session import Session
from arael.sketch.commands.table import command
from arael.sketch.commands.tokens import fail
from arael.sketch.transfer.converting import converted


@command(
    "help",
    group="session",
    usage=["help", "help full", "help COMMAND", "help GROUP", "help coordinates"],
    summary="Show the commands, one command, or the whole manual.",
    arguments=("topic=",),
)
def help_(session: Session, words: Words) -> Reply:
    """Show help."""
    token = words.peek()
    topic = words.next("").text if token is not None else ""
    words.end()
    if not topic:
        return Reply(manual.summary(), remembered=False)
    if topic == "full":
        return Reply(manual.full(), remembered=False)
    found = table.find(topic)
    if found is not None:
        return Reply(manual.of_command(found), remembered=False)
    if topic in manual.TOPICS or topic in table.GROUPS:
        return Reply(manual.of_topic(topic), remembered=False)
    known = [*table.words(), *table.GROUPS, *manual.TOPICS]
    near = closest(topic, known)
    hint = f"did you mean `{near[0]}`?" if near else "`help` lists the commands"
    assert token is not None
    fail("E1250", f"no command or topic `{topic[:60]}`", token.span, "", hint)


@command(
    "msg",
    group="session",
    usage=["msg TEXT"],
    summary="Show a text, as Markdown; `\\n` begins a new line.",
    arguments=("text",),
    whole=True,
)
def msg(session: Session, words: Words) -> Reply:
    """Show a text."""
    text = words.rest().replace("\\n", "\n")
    if not text:
        words.missing("a text")
    return Reply(text, remembered=False, data={"message": text})


@command(
    "timing",
    group="session",
    usage=["timing on", "timing off", "timing"],
    summary="Show how long every command line takes.",
    arguments=("switch=",),
)
def timing(session: Session, words: Words) -> Reply:
    """Show how long every command line takes."""
    if words:
        session.state.timing = words.choice("`on` or `off`", "on", "off") == "on"
    words.end()
    state = "on" if session.state.timing else "off"
    return Reply(f"Timing is {state}", remembered=False, data={"timing": state})


@command(
    "settings",
    group="session",
    usage=["settings", "settings NAME on", "settings NAME off", "settings unit in convert"],
    summary="Show the switches, or set one; `unit` is that of lengths: mm, cm, m, in.",
    details="""
`structural_dof`: the number of degrees of freedom follows connections without a new analysis. It is
always exact here, so that the switch changes nothing; scripts that set it keep working.
The unit tells what a plain number means. With `convert` every length is converted, so that the part
keeps its size; with `relabel`, or nothing, numbers stay as they are, so that its size changes.
""",
    arguments=("name=", "value=", "how="),
)
def settings(session: Session, words: Words) -> Reply:
    """Show or set switches."""
    known = session.state.settings
    if words:
        name = words.choice("a setting", *known, "unit")
        if name == "unit":
            unit = words.choice("a unit", "mm", "cm", "m", "in")
            how = words.accept("convert", "relabel")
            words.end()
            with session.document.transaction("unit"):
                if how == "convert":
                    converted(session.editor, unit)
                session.document.set_setting("unit", unit)
                session.editor.solve()
        else:
            known[name] = words.choice("`on` or `off`", "on", "off") == "on"
            words.end()
    lines = [f"{name} {'on' if value else 'off'}" for name, value in known.items()]
    lines.append(f"unit {session.document.unit}")
    return Reply("\n".join(lines), remembered=False, data={"unit": session.document.unit, **known})


@command(
    "exit",
    group="session",
    usage=["exit"],
    summary="Leave the editor.",
    aliases=("quit",),
    arguments=(),
    outside=True,
)
def leave(session: Session, words: Words) -> Reply:
    """Leave."""
    words.end()
    return Reply("", leaves=True, remembered=False)
