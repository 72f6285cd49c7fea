"""What the commands that create geometry share: connections, words at the end, replies."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from arael.diagnostics.records import AraelError
from arael.sketch.commands.numbers import place
from arael.sketch.commands.reading import Place, Words, placed
from arael.sketch.commands.replies import Reply
from arael.sketch.commands.session import Session
from arael.sketch.document.records import Constraint, Entity
from arael.sketch.editing.directions import direction_at
from arael.sketch.editing.results import Added
from arael.sketch.expressions.vectors import Vec

#: Words that may stand behind every command that creates.
COMMON = ("noconnect", "nocursor", "quiet", "constr")


@contextmanager
def placed_at(words: Words) -> Iterator[None]:
    """Refusals of the editor, at the place of the command's word."""
    try:
        yield
    except AraelError as error:
        if any(one.span is not None for one in error.diagnostics):
            raise
        raise placed(error, words.span) from None


def add(
    session: Session,
    words: Words,
    kind: str,
    numbers: Sequence[float],
    *,
    text: str = "",
    clockwise: bool = False,
) -> Added:
    """Add an entity with the flags of the command."""
    with placed_at(words):
        return session.editor.add(
            kind,
            numbers,
            connect="noconnect" not in words.flags,
            tangent="notangent" not in words.flags and not text,
            construction="constr" in words.flags,
            quiet="quiet" in words.flags,
            text=text,
            clockwise=clockwise,
        )


def drive(session: Session, words: Words, *dimensions: tuple[str, str]) -> list[str]:
    """With `driven`, dimensions at the values they have; their names.

    One that holds nothing new is left out and said; with `strict` it is an error.
    """
    if "driven" not in words.flags:
        return []
    said = []
    for kind, name in dimensions:
        try:
            with session.document.transaction("driven"):
                made = session.editor.dimension(kind, (name,))
            said.append(f" [{made.name}: {kind} {name}]")
        except AraelError as error:
            if "strict" in words.flags:
                raise placed(error, words.span) from None
            said.append(f" [no {kind} of {name}: {error.diagnostics[0].message}]")
    return said


def connections(added: Sequence[Added]) -> str:
    """What was connected by itself, for the reply."""
    connected = [one for a in added for one in a.connected]
    tangents = [one for a in added for one in a.tangents]
    parts = []
    if connected:
        parts.append(f"[connected: {', '.join(_coincident(one) for one in connected)}]")
    if tangents:
        parts.append(f"[tangent: {', '.join(_tangent(one) for one in tangents)}]")
    return "".join(f" {part}" for part in parts)


def _coincident(one: Constraint) -> str:
    return f"{one.args[0]}={one.args[1]} ({one.name})"


def _tangent(one: Constraint) -> str:
    return f"{one.args[0]}.tangent.{one.args[1]} ({one.name})"


def leave_cursor(session: Session, words: Words, entity: Entity, end: str) -> None:
    """Put the cursor at an end or the centre of a new entity, unless `nocursor`."""
    if "nocursor" in words.flags:
        return
    handle = entity.name if entity.kind == "point" else f"{entity.name}.{end}"
    at = session.document.point_at(handle)
    x, y = session.document.values[at : at + 2].tolist()
    tangent = direction_at(session.document, handle) if end not in ("pos", "center") else None
    if tangent is not None and entity.clockwise:
        tangent = -tangent[0], -tangent[1]
    session.move_cursor(
        Vec(x, y), Vec(*tangent) if tangent else None, chain=end not in ("pos", "center")
    )


def reply(text: str, added: Sequence[Added], dimensions: Sequence[str] = ()) -> Reply:
    """The answer of a command that created entities."""
    names = tuple(a.entity.name for a in added)
    return Reply(
        f"Added {text}{connections(added)}{''.join(dimensions)}",
        names,
        data={
            "entities": list(names),
            "connected": [one.name for a in added for one in a.connected],
            "tangents": [one.name for a in added for one in a.tangents],
        },
    )


def shown_line(name: str, a: Place | Vec, b: Place | Vec) -> str:
    """``L0: (0, 0)-(5, 0)``."""
    return f"{name}: {place(a.x, a.y)}-{place(b.x, b.y)}"
