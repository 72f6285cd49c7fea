"""E1231 is said with a proof; without one a refusal says what was tried."""

from __future__ import annotations

import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.commands.session import Session
from arael.sketch.solve.search import Search
from arael.sketch.solve.solver import Solver

#: A script, and what contradicts it: a triangle, directions, a chain that is too short.
CONTRADICTIONS = [
    ("add_line 0,0 1,0 0.5,1 0,0; length L0 1; length L1 1", "length L2 3"),
    ("add_line 0,0 5,0; horizontal L0", "vertical L0"),
    ("add_rect 0,0 4,2 hv", "perpendicular L0 L2"),
    ("add_line 2,-8 -1,-7 5,-10; horizontal L1; perpendicular L0 L1", "vertical L1"),
    ("add_line 0,0 10,0 20,0; length L0 10; length L1 10; lock L0.p1", "distance L0.p1 L1.p2 25"),
    ("add_circle 0,0 2; add_point 1,1; lock A0.center; radius A0 2; point_on P0 A0",
     "hdistance A0.center P0 3"),
]  # fmt: skip


def code(session: Session, line: str) -> tuple[str, str]:
    with pytest.raises(AraelError) as caught:
        session.run(line)
    found = caught.value.diagnostics[0]
    return found.code, "\n".join(found.notes)


@pytest.mark.parametrize(("script", "line"), CONTRADICTIONS)
def test_contradictions_are_proven(script: str, line: str) -> None:
    session = Session()
    session.run(script)
    assert code(session, line)[0] == "E1231"


def test_a_small_figure_in_a_large_drawing_is_proven_impossible() -> None:
    session = Session()
    session.run("add_rect 0,0 5,3; add_rect 5,3 9,5; length L0 4; add_line 0,-5 1e5,-5")
    assert code(session, "parallel L0 L1")[0] == "E1231"


#: What has a solution, which steps of least change do not find.
SOLVABLE = [
    ("add_line 0,0 10,0 20,0; length L0 10; length L1 10; lock L0.p1", "distance L0.p1 L1.p2 15"),
    ("add_circle 0,0 10; lock A0.center; radius A0 10; add_point 10,0; point_on P0 A0",
     "vertical P0 A0.center"),
    ("add_line -2.6,5.7 -6.3,7.7; add_line 0,-1.4 6,9.7; perpendicular L1 L0; length L1 driven",
     "horizontal L0.p1 L0.p2"),
]  # fmt: skip


@pytest.mark.parametrize(("script", "line"), SOLVABLE)
def test_trials_that_fail_are_no_proof(
    script: str, line: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Search, "solution", lambda _: None)
    monkeypatch.setattr(Solver, "feasible", lambda _, names: len(names) < 2)
    session = Session()
    session.run(script)
    found, notes = code(session, line)
    assert found in ("E1220", "E1233", "E1234")
    if found == "E1234":
        assert "tried" in notes
