"""Sketches from scripts, and what tests ask of them."""

from __future__ import annotations

from typing import Any

import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.commands.replies import Reply
from arael.sketch.commands.session import Session


def sketch(script: str) -> Session:
    session = Session()
    session.run(script)
    return session


def run(session: Session, line: str) -> Reply:
    return session.run(line)[-1]


def number(session: Session, expression: str) -> float:
    value: Any = session.scope.value(expression)
    return float(value)


def at(session: Session, handle: str) -> tuple[float, float]:
    offset = session.document.point_at(handle)
    x, y = session.document.values[offset : offset + 2].tolist()
    return x, y


def state(session: Session) -> tuple[Any, ...]:
    document = session.document
    tables = ("entities", "constraints", "dimensions", "parameters", "groups")
    return (
        [list(getattr(document, table).items()) for table in tables],
        document.values.tobytes(),
        dict(document.settings),
    )


def measures(session: Session, name: str) -> float:
    one = session.document.dimensions[name]
    return abs(session.editor.measure(one.kind, one.args, one.mode))


def refused(session: Session, line: str) -> tuple[str, str, str]:
    """Code, message, and the text that the place shows; nothing is changed."""
    before, steps = state(session), session.document.history.position
    with pytest.raises(AraelError) as caught:
        session.run(line)
    assert state(session) == before
    assert session.document.history.position == steps
    first = caught.value.diagnostics[0]
    assert first.span is not None
    span = first.span
    return first.code, first.message, span.source.text[span.start : span.end]


def kinds(session: Session) -> list[tuple[str, tuple[str, ...]]]:
    return [(one.kind, one.args) for one in session.document.constraints.values()]
