"""Sketches by script, and their freedoms."""

from __future__ import annotations

import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.commands.session import Session


def sketch(script: str) -> Session:
    session = Session()
    session.run(script)
    return session


def freedom(session: Session) -> int:
    session.editor.layout.refresh()
    return int(session.editor.judge.freedoms().total)


def number(session: Session, expression: str) -> float:
    return float(session.scope.value(expression))  # type: ignore[arg-type]


def at(session: Session, handle: str) -> tuple[float, float]:
    offset = session.document.point_at(handle)
    x, y = session.document.values[offset : offset + 2].tolist()
    return x, y


def code(session: Session, script: str) -> str:
    with pytest.raises(AraelError) as caught:
        session.run(script)
    return str(caught.value.diagnostics[0].code)
