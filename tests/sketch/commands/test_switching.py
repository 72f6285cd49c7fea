"""`switch_off` and `switch_on`: relations that stay listed and do not act."""

from __future__ import annotations

import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.commands.session import Session


@pytest.fixture
def session() -> Session:
    made = Session()
    made.run("add_rect 0,0 10,4 hv\nlength L0 10")
    return made


def freedoms(session: Session) -> int:
    return int(session.run("dof")[-1].data["freedoms"])


def test_what_is_switched_off_leaves_a_freedom_and_stays_listed(session: Session) -> None:
    before = freedoms(session)
    (reply,) = session.run("switch_off CL0H d0")
    assert freedoms(session) == before + 2
    assert reply.text == "CL0H: horizontal L0 [off]\nd0: length L0 = 10 [off]"
    assert not session.document.constraints["CL0H"].active


def test_switched_on_it_holds_again(session: Session) -> None:
    session.run("switch_off d0\ndrag L1.p1 20,1")
    assert session.document.numbers_of("L0")[2] > 12.0
    session.run("switch_on d0")
    x1, _, x2, _ = session.document.numbers_of("L0")
    assert x2 - x1 == pytest.approx(10.0)


def test_what_has_become_redundant_is_refused_and_stays_off(session: Session) -> None:
    session.run("switch_off CL0H\nparallel L0 L2")
    with pytest.raises(AraelError) as refused:
        session.run("switch_on CL0H")
    assert refused.value.diagnostics[0].code == "E1230"
    assert not session.document.constraints["CL0H"].active


def test_it_is_one_step_of_undo(session: Session) -> None:
    session.run("switch_off CL0H CL1V d0\nundo")
    assert all(one.active for one in session.document.constraints.values())
    assert session.document.dimensions["d0"].active


@pytest.mark.parametrize(
    ("text", "code", "help_"),
    [
        ("switch_off CL0V", "E1201", "did you mean `CL0H`?"),
        ("switch_off L0", "E1256", "`list constraints`"),
        ("switch_on", "E1251", ""),
    ],
)
def test_what_is_no_constraint_is_refused(
    session: Session, text: str, code: str, help_: str
) -> None:
    with pytest.raises(AraelError) as refused:
        session.run(text)
    found = refused.value.diagnostics[0]
    assert found.code == code
    assert help_ in "".join(found.help)
