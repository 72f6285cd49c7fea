"""Drawings whose parts differ in size by orders of magnitude."""

from __future__ import annotations

import pytest

from arael.diagnostics.records import AraelError, Diagnostic
from arael.sketch.commands.session import Session


def test_what_is_left_is_solved_by_its_own_measure() -> None:
    session = Session()
    session.run("add_line 0,0 3,4; length L0 5; add_line 3,4 1e13,4")
    document = session.document

    def length() -> float:
        return float(session.editor.measure("length", ("L0",)))

    with document.transaction("off by less than 1e-10 of the drawing's size"):
        document.set_values([0], [-0.5])
    off = length()
    assert off > 5.3
    session.run("delete L1")
    assert length() == pytest.approx(5.0, abs=1e-12)
    session.run("undo")
    assert length() == off


def test_a_solve_that_is_refused_after_a_deletion_leaves_nothing_behind(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    session = Session()
    session.run("add_line 0,0 3,4; length L0 5; add_line 3,4 1e13,4")
    document, editor = session.document, session.editor
    with document.transaction("off by less than 1e-10 of the drawing's size"):
        document.set_values([0], [-0.5])
    before = document.numbers_of("L0").tolist()

    def refused(cause: str = "") -> None:
        document.set_values([0], [3.0])
        raise AraelError(Diagnostic("E1220", "would leave nothing"))

    monkeypatch.setattr(editor, "_settle", refused)
    session.run("delete L1")
    assert "L1" not in document.entities
    assert document.numbers_of("L0").tolist() == before
