"""What a beginner types: the message names the cause, and the sketch stays as it was."""

from __future__ import annotations

import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.commands.session import Session
from arael.sketch.document.saved import to_json


@pytest.fixture
def session() -> Session:
    session = Session()
    session.run("add_line 0,0 4,0")
    return session


@pytest.mark.parametrize(
    ("line", "code", "message", "hint"),
    [
        (
            "add_line (1,2) (3,4)",
            "E1253",
            "expected a coordinate, found `(1,2)`",
            "write `1,2`, without parentheses",
        ),
        (
            "add_circle (L0.p2.x, 2) 1",
            "E1253",
            "expected the centre, found `(L0.p2.x, 2)`",
            "write `L0.p2.x, 2`, without parentheses",
        ),
        ("zoom 0", "E1257", "a factor is at least 1e-09, found 0", ""),
        ("goto 7", "E1266", "the history has 1 step, found 7", "`history` shows the steps"),
        ("add_point (1,2", "E1258", "`(` is not closed", ""),
    ],
)
def test_a_mistake_is_named_and_changes_nothing(
    session: Session, line: str, code: str, message: str, hint: str
) -> None:
    before = to_json(session.document)
    with pytest.raises(AraelError) as caught:
        session.run(line)
    first = caught.value.diagnostics[0]
    assert (first.code, first.message) == (code, message)
    assert hint in " ".join(first.help)
    assert to_json(session.document) == before


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("undo 9", "there was 1 step to undo, not 9"),
        ("help parallel", "Takes 1 degree of freedom."),
        ("help coincident", "Takes 2 degrees of freedom."),
    ],
)
def test_a_count_of_one_is_singular(session: Session, line: str, expected: str) -> None:
    (reply,) = session.run(line)
    assert expected in reply.text.splitlines()
