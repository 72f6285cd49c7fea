"""A dimension that is changed again and again: what stays as it was is not looked at anew."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.commands.session import Session
from arael.sketch.editing import remaining
from arael.sketch.solve.solver import Solver

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
    for value in (61, 60, 61, 60, 61, 60):
        session.run(f"length L0 {value}")

    def refused(*_: object, **__: object) -> None:
        raise AssertionError("this depends on the whole drawing")

    monkeypatch.setattr(np, "median", refused)
    monkeypatch.setattr(remaining, "check_remains", refused)
    for value in (61, 60):
        session.run(f"length L0 {value}")
    assert session.editor.measure("length", ("L0",)) == pytest.approx(60.0, abs=1e-9)


def test_what_would_collapse_is_refused_the_first_time_and_later() -> None:
    session = drawn("add_line 0,0 4,0; add_line 4,0 4,3; horizontal L0; lock L0.p1; length L0 4")
    session.run("hdistance L0.p1 L1.p2 4; vdistance L0.p1 L1.p2 3")
    for _ in range(3):
        before = session.document.values.tobytes()
        with pytest.raises(AraelError, match="together with `CL0H`, `d0` and `d1`"):
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

    def components(rows: object) -> None:
        raise AssertionError("the structure is as it was")

    monkeypatch.setattr("arael.sketch.layout.system.components", components)
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


def test_what_holds_already_is_not_analysed(monkeypatch: pytest.MonkeyPatch) -> None:
    session = drawn("add_line 0,0 4,0; add_line 4,0 4,3; add_line 4,3 0,0")

    def solve(*_: object, **__: object) -> None:
        raise AssertionError("all equations hold")

    monkeypatch.setattr(Solver, "_newton", solve)
    before = session.document.values.tobytes()
    session.run("horizontal L0; vertical L1; length L0 4; length L1 3")
    assert session.document.values.tobytes() == before
    monkeypatch.undo()
    session.run("length L0 5")
    assert session.editor.measure("length", ("L0",)) == pytest.approx(5.0, abs=1e-12)
    with pytest.raises(AraelError):
        session.run("length L2 9")


def test_unknowns_follow_every_change_of_numbers() -> None:
    session = drawn("add_line 0,0 4,0; horizontal L0; length L0 4")
    layout, document = session.editor.layout, session.document
    first = layout.gather().copy()
    assert layout.gather() is layout.x
    session.run("length L0 5")
    assert not np.array_equal(layout.gather(), first)
    session.run("undo")
    np.testing.assert_array_equal(layout.gather(), first)
    size = layout.size
    with document.transaction("moved"):
        document.set_values([0, 2], [-40.0, -36.0])
    assert layout.gather()[0] == -40.0
    assert layout.size == size
    session.run("add_line 0,0 0,100")
    assert layout.size == 100.0
    session.run("undo")
    assert layout.size == size


def test_unknowns_have_bounds_only_where_some_are_hidden() -> None:
    session = drawn("add_line 0,0 4,0; length L0 4")
    layout = session.editor.layout
    assert layout.bounds[0] is None
    session.run("add_point 1,1; distance P0 L0.p1 1 to 3")
    bounds = layout.bounds
    assert bounds[0] is layout.low
    assert bounds[1] is layout.high
    session.run("undo 2")
    layout.refresh()
    assert not layout.has_hidden


def test_a_line_keeps_its_length_when_its_angle_changes() -> None:
    session = Session()
    session.run("add_line 0,0 10,0 noconnect")
    for value in (80, 160, -120, 0, 30):
        session.run(f"xangle L0 {value}")
        x1, y1, x2, y2 = session.document.numbers_of("L0").tolist()
        assert math.hypot(x2 - x1, y2 - y1) == pytest.approx(10, abs=1e-9)
        turned = math.degrees(math.atan2(y2 - y1, x2 - x1))
        assert math.remainder(turned - value, 360) == pytest.approx(0, abs=1e-7)
    session.run("add_line 0,20 10,20; add_line 0,20 0,28")
    for words in ("40", "120", "30 supplement", "100"):
        session.run(f"angle L1 L2 {words}")
        assert session.document.numbers_of("L1").tolist() == [0, 20, 10, 20]
        assert session.editor.measure("length", ("L2",)) == pytest.approx(8, abs=1e-9)
