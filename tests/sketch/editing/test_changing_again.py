"""A dimension that is changed again and again: what stays as it was is not looked at anew."""

from __future__ import annotations

import numpy as np
import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.commands.session import Session
from arael.sketch.editing import editor as editing
from arael.sketch.layout.system import System

PLATE = """
add_rect 0,0 60,40 hv
add_circle 10,10 4
length L0 60
length L1 40
"""


def drawn(text: str) -> Session:
    session = Session()
    session.run(text)
    return session


def test_neither_sorts_nor_looks_at_entities_one_by_one(monkeypatch: pytest.MonkeyPatch) -> None:
    session = drawn(PLATE)
    for value in (61, 60):
        session.run(f"length L0 {value}")

    def refused(*_: object, **__: object) -> None:
        raise AssertionError("this depends on the whole drawing")

    monkeypatch.setattr(np, "median", refused)
    monkeypatch.setattr(editing, "check_remains", refused)
    for value in (61, 60):
        session.run(f"length L0 {value}")
    assert session.editor.measure("length", ("L0",)) == pytest.approx(60.0, abs=1e-9)


def test_what_would_collapse_is_refused_the_first_time_and_later() -> None:
    session = drawn("add_line 0,0 4,0; add_line 4,0 4,3; horizontal L0; lock L0.p1; length L0 4")
    session.run("hdistance L0.p1 L1.p2 4; vdistance L0.p1 L1.p2 3")
    for _ in range(3):
        before = session.document.values.tobytes()
        with pytest.raises(AraelError, match="nothing of `L1`"):
            session.run("vdistance L0.p1 L1.p2 0")
        assert session.document.values.tobytes() == before
        session.run("length L0 5")
        session.run("length L0 4")


def test_components_and_slacks_are_kept_while_the_structure_is(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    session = drawn(PLATE)
    session.run("length L0 61")
    layout = session.editor.layout
    slacks = layout.slacks

    def components(self: System) -> None:
        raise AssertionError("the structure is as it was")

    monkeypatch.setattr(System, "components", components)
    session.run("length L0 62")
    assert layout.slacks is slacks
    monkeypatch.undo()
    session.run("distance L0.p1 A0.center 10 to 20")
    assert len(layout.slacks) == 2


def test_numbers_of_a_document_are_one_view_that_follows_it() -> None:
    session = drawn("add_line 0,0 3,4")
    document = session.document
    values = document.values
    assert values is document.values
    assert not values.flags.writeable
    with document.transaction("moved"):
        document.set_values([0], [1.0])
    assert values[0] == 1.0
    session.run("add_line 9,9 12,12")
    assert len(document.values) == 8
    assert not document.values.flags.writeable
    session.run("undo")
    assert len(document.values) == 4


def test_a_part_of_a_step_that_fails_leaves_the_step_open() -> None:
    document = drawn("add_line 0,0 3,4").document
    done = document.history.position
    with document.transaction("whole"):
        document.set_values([0], [1.0])
        with pytest.raises(RuntimeError), document.transaction("part"):
            document.set_values([1], [2.0])
            raise RuntimeError
        assert document.open_transaction is not None
    assert document.history.position == done + 1
    assert document.values.tolist() == [1.0, 0.0, 3.0, 4.0]
    with pytest.raises(RuntimeError), document.transaction("fails"):
        document.set_values([0], [5.0])
        raise RuntimeError
    assert not document.is_changing
    assert document.values[0] == 1.0
