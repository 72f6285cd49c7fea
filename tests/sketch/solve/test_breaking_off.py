"""Edits that another thread breaks off, and frames of a drag that have little time."""

from __future__ import annotations

from threading import Thread
from typing import Any

import numpy as np
import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.commands.session import Session
from arael.sketch.solve.solver import Solver

CHAIN = (
    "add_line 0,0 2,1 4,0 6,1 8,0; lock L0.p1; length L0 2; length L1 2; length L2 2; length L3 2"
)


@pytest.fixture
def chain() -> Session:
    session = Session()
    session.run(CHAIN)
    return session


def interrupt_in(monkeypatch: pytest.MonkeyPatch, session: Session, method: str) -> list[None]:
    """Have another thread interrupt when a method of the solver begins; a note per call."""
    original = getattr(Solver, method)
    calls: list[None] = []

    def interrupted(self: Solver, *args: Any, **more: Any) -> Any:
        calls.append(None)
        other = Thread(target=session.editor.solver.interrupt)
        other.start()
        other.join()
        return original(self, *args, **more)

    monkeypatch.setattr(Solver, method, interrupted)
    return calls


def refusal(session: Session, line: str) -> str:
    with pytest.raises(AraelError) as error:
        session.run(line)
    return str(error.value.diagnostics[0].code)


@pytest.mark.parametrize("method", ["solve", "_newton"])
def test_an_edit_that_is_broken_off_changes_nothing(
    chain: Session, monkeypatch: pytest.MonkeyPatch, method: str
) -> None:
    document = chain.editor.document
    before, steps = document.values.tobytes(), len(document.history.done)
    with monkeypatch.context() as patch:
        calls = interrupt_in(patch, chain, method)
        assert refusal(chain, "length L0 3") == "E1235"
        assert calls
    assert document.values.tobytes() == before
    assert len(document.history.done) == steps
    chain.run("length L0 3")
    assert chain.editor.measure("length", ["L0"]) == pytest.approx(3)


def test_a_reason_that_is_looked_for_when_it_is_broken_off_is_not_given(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    session = Session()
    session.run("add_line 0,0 1,0 0.5,0.8 0,0; length L0 1; length L1 1")
    with monkeypatch.context() as patch:
        interrupt_in(patch, session, "feasible")
        assert refusal(session, "length L2 3") == "E1235"
    assert refusal(session, "length L2 3") == "E1231"


def test_between_edits_nothing_is_broken_off(chain: Session) -> None:
    chain.editor.solver.interrupt()
    assert not chain.editor.solver.interrupted
    chain.run("length L0 3")


def test_the_rest_of_a_step_of_undo_is_broken_off_too(chain: Session) -> None:
    editor = chain.editor
    before = editor.document.values.tobytes()
    with pytest.raises(AraelError), editor.document.transaction("two"):
        editor.solver.interrupt()
        with pytest.raises(AraelError):
            chain.run("length L0 3")
        chain.run("length L1 3")
    assert editor.document.values.tobytes() == before
    chain.run("length L0 3")


def test_a_drag_whose_frames_have_no_time_arrives_by_and_by(chain: Session) -> None:
    editor = chain.editor
    with editor.dragging(["L3.p2"]) as drag:
        outcomes = []
        for _ in range(30):
            outcomes.append(drag.to((5.0, 4.0), seconds=0.0))
            assert outcomes[-1].solved
            for line in ("L0", "L1", "L2", "L3"):
                assert editor.measure("length", [line]) == pytest.approx(2, abs=1e-8)
    assert not outcomes[0].converged
    at = editor.document.point_at("L3.p2")
    assert np.allclose(editor.document.values[at : at + 2], [5, 4])
