"""`image`: copies that follow their source."""

from __future__ import annotations

import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.commands.session import Session


def numbers(session: Session, name: str) -> list[float]:
    found: list[float] = session.document.numbers_of(name).tolist()
    return found


def test_a_shifted_copy_follows() -> None:
    session = Session()
    session.run("add_line 0,0 4,0; add_line 10,1 13,2 noconnect; image L0 L1 shift 10,1")
    a, b = numbers(session, "L0"), numbers(session, "L1")
    assert b == pytest.approx([a[0] + 10, a[1] + 1, a[2] + 10, a[3] + 1])
    session.run("lock L0.p1 0,0; length L0 6; vertical L0")
    a, b = numbers(session, "L0"), numbers(session, "L1")
    assert b == pytest.approx([a[0] + 10, a[1] + 1, a[2] + 10, a[3] + 1])
    assert session.editor.judge.freedoms().total == 0


def test_a_turned_copy_follows() -> None:
    session = Session()
    session.run("add_point 0,0; lock P0; add_circle 5,0 1; add_circle 0,4 2")
    session.run("image A0 A1 rotate 90 about P0")
    session.run("lock A0.center 6,1; radius A0 1.5")
    assert numbers(session, "A1") == pytest.approx([-1, 6, 1.5])


@pytest.mark.parametrize(
    ("line", "code"),
    [
        ("image L0 P0 shift 1,1", "E1256"),
        ("image L0 L1 mirror", "E1252"),
        ("image L0 L1 rotate", "E1251"),
        ("image L0 L1", "E1251"),
    ],
)
def test_refusals(line: str, code: str) -> None:
    session = Session()
    session.run("add_line 0,0 4,0; add_line 10,1 13,2; add_point 1,1")
    with pytest.raises(AraelError) as caught:
        session.run(line)
    assert caught.value.diagnostics[0].code == code
    assert not session.document.constraints
