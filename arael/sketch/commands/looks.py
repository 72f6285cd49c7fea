"""`constr`, `quiet` and `style`: what entities are drawn as."""

from __future__ import annotations

from collections.abc import Callable

from arael.sketch.commands.reading import Operand, Words
from arael.sketch.commands.replies import Reply
from arael.sketch.commands.session import Session
from arael.sketch.commands.table import command
from arael.sketch.commands.tokens import fail
from arael.sketch.document.records import STYLES


def _entities(words: Words, *ends: str) -> list[Operand]:
    """Take entities, up to one of the words."""
    found: list[Operand] = []
    while words and words.items[0].text not in ends:
        if words.items[0].text == "selection":
            found += [one for one in words.selected() if not one.point]
        else:
            found.append(words.operand("an entity", "entity"))
    if not found:
        words.missing("an entity")
    return list({one.handle: one for one in found}.values())


def _switch(flag: str, said: tuple[str, str]) -> Callable[[Session, Words], Reply]:
    def run(session: Session, words: Words) -> Reply:
        found = _entities(words, "on", "off")
        state = words.choice("`on` or `off`", "on", "off") if words else ""
        words.end()
        lines = []
        now: dict[str, bool] = {}
        with session.document.transaction(words.statement.text):
            for one in found:
                value = state == "on" if state else not getattr(one.entity, flag)
                session.editor.change_entity(one.handle, **{flag: value})
                now[one.handle] = value
                lines.append(f"{one.handle}: {said[0] if value else said[1]}")
        return Reply("\n".join(lines), remembered=False, data={flag: now})

    return run


command(
    "constr",
    group="modify",
    usage=("constr L0 [L1 ...]", "constr L0 on", "constr L0 off", "constr selection"),
    summary="Make entities construction geometry or ordinary again; toggle without `on`, `off`.",
    arguments=("*entities",),
)(_switch("construction", ("construction", "no construction")))

command(
    "quiet",
    group="modify",
    usage=("quiet L0 [L1 ...]", "quiet L0 on", "quiet L0 off", "quiet selection"),
    summary="Hide the dimensions and centre of entities, or show them; toggle without `on`, `off`.",
    arguments=("*entities",),
)(_switch("quiet", ("quiet", "not quiet")))


@command(
    "style",
    group="modify",
    usage=("style L0 [L1 ...] solid", "style L0 dashed", "style L0 dashdot", "style L0"),
    summary="Set the line style of entities, or ask for it.",
    arguments=("*words",),
)
def style(session: Session, words: Words) -> Reply:
    """Set the line style."""
    last = words.items[-1] if words else None
    names_style = last is not None and (
        last.text in STYLES or (len(words) > 1 and words.find(last) is None
                                and last.text != "selection")
    )  # fmt: skip
    found = _entities(words, *STYLES, *([last.text] if names_style and last is not None else []))
    if not words:
        lines = [f"{one.handle}: {one.entity.style}" for one in found]
        data = {one.handle: one.entity.style for one in found}
        return Reply("\n".join(lines), remembered=False, data={"style": data})
    chosen = words.choice("a style", *STYLES)
    words.end()
    for one in found:
        if one.entity.kind == "point":
            fail("E1256", f"`{one.handle}` is a point: it has no line style", one.token.span)
    with session.document.transaction(words.statement.text):
        for one in found:
            session.editor.change_entity(one.handle, style=chosen)
    lines = [f"{one.handle}: {chosen}" for one in found]
    return Reply(
        "\n".join(lines), remembered=False, data={"style": {one.handle: chosen for one in found}}
    )
