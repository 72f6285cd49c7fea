"""Drawings whose parts differ in size by orders of magnitude."""

from __future__ import annotations

import pytest

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
