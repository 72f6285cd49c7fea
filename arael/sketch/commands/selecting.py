"""`select` and `deselect`."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from arael.sketch.commands.numbers import listed
from arael.sketch.commands.reading import Operand, Words
from arael.sketch.commands.replies import Reply
from arael.sketch.commands.session import Session
from arael.sketch.commands.table import command
from arael.sketch.commands.tokens import fail
from arael.sketch.document.document import Document
from arael.sketch.document.handles import ends
from arael.sketch.document.records import Entity
from arael.sketch.groups.ties import places


def chained(document: Document, start: str) -> list[str]:
    """Entities that are connected with one by coincident points, through others too."""
    at: dict[str, set[str]] = {}
    of: dict[str, set[str]] = {}
    for handle, place in places(document).items():
        name = handle.partition(".")[0]
        at.setdefault(place, set()).add(name)
        of.setdefault(name, set()).add(place)
    return _reached(document, start, lambda name: (n for p in of.get(name, ()) for n in at[p]))


def linked(document: Document, start: str) -> list[str]:
    """Entities that share a constraint or dimension with one, through others too."""
    near: dict[str, set[str]] = {}
    for table in (document.constraints, document.dimensions):
        for record in table.values():
            names = {arg.partition(".")[0] for arg in record.args}
            for name in names:
                near.setdefault(name, set()).update(names)
    return _reached(document, start, lambda name: near.get(name, ()))


def _reached(document: Document, start: str, next_to: Callable[[str], Iterable[str]]) -> list[str]:
    seen = {start}
    waiting = [start]
    while waiting:
        for other in next_to(waiting.pop()):
            if other not in seen:
                seen.add(other)
                waiting.append(other)
    return [name for name in document.entities if name in seen]


def sequence(document: Document, start: str) -> list[str]:
    """Curves end to end through one, both ways up to an end or a branch, in their order."""
    ties = places(document)
    ends_at: dict[str, list[str]] = {}
    for entity in document.entities.values():
        for point in ends(entity):
            handle = f"{entity.name}.{point}"
            ends_at.setdefault(ties.get(handle, handle), []).append(handle)

    def walk(entity: Entity, point: str) -> list[str]:
        found: list[str] = []
        seen = {entity.name}
        handle = f"{entity.name}.{point}"
        while True:
            here = ends_at[ties.get(handle, handle)]
            others = [one for one in here if one != handle]
            if len(others) != 1:
                return found
            name = others[0].partition(".")[0]
            if name in seen:
                return found
            seen.add(name)
            found.append(name)
            first, last = ends(document.entities[name])
            handle = f"{name}.{last if others[0].endswith('.' + first) else first}"

    entity = document.entities[start]
    if not ends(entity):
        return [start]
    first, last = ends(entity)
    forward = walk(entity, last)
    backward = [name for name in walk(entity, first) if name not in forward]
    return [*reversed(backward), start, *forward]


_WALKS = {"chain": chained, "linked": linked, "sequence": sequence}


@command(
    "select",
    group="select",
    usage=[
        "select L0 [L0.p1 A0.center ...]",
        "select all",
        "select L0 chain",
        "select L0 linked",
        "select L0 sequence",
        "select M0",
    ],
    summary="Add to the selection, or select everything that hangs together.",
    details="""
`chain`: what is connected by coincident points; `linked`: what shares any constraint or dimension;
`sequence`: curves end to end, up to an end or a branch. These, and `all`, replace the selection.
""",
    keywords=("chain", "linked", "sequence"),
    arguments=("*names",),
)
def select(session: Session, words: Words) -> Reply:
    """Select."""
    words.refuse_together("chain", "linked", "sequence")
    document, state = session.document, session.state
    if words.accept("all"):
        words.end()
        state.selection = dict.fromkeys(document.entities)
        return _said(session)
    names = _names(session, words)
    walk = next((word for word in _WALKS if word in words.flags), "")
    if walk:
        starts = [name.partition(".")[0] for name in names]
        found = [one for start in starts for one in _WALKS[walk](document, start)]
        state.selection = dict.fromkeys(found)
    else:
        state.selection.update(dict.fromkeys(names))
    return _said(session)


@command(
    "deselect",
    group="select",
    usage=["deselect", "deselect L0 ..."],
    summary="Clear the selection, or take something out of it.",
    arguments=("*names",),
)
def deselect(session: Session, words: Words) -> Reply:
    """Deselect."""
    if not words or words.accept("all"):
        words.end()
        session.state.selection = {}
    else:
        for name in _names(session, words):
            session.state.selection.pop(name, None)
    return _said(session)


def _names(session: Session, words: Words) -> list[str]:
    """Take handles, and names of groups."""
    found: list[str] = []
    while words:
        token = words.next("")
        name = session.resolve(token.text)
        if name in session.document.groups:
            found.append(name)
        else:
            one: Operand = words.require(token, "an entity, a point or a group")
            found.append(one.handle)
    if not found:
        words.missing("what to select")
    if words.flags and any(name in session.document.groups for name in found):
        message = f"`{sorted(words.flags)[0]}` goes from an entity, not from a group"
        fail("E1256", message, words.statement.span)
    return found


def _said(session: Session) -> Reply:
    names = session.selection
    return Reply(
        f"Selected: {listed(names, 20)}" if names else "Nothing is selected",
        remembered=False,
        data={"selection": names},
    )
