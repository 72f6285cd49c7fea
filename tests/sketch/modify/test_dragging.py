"""`drag`: points and bodies, absolute and relative, held and refused."""

from __future__ import annotations

import pytest

from tests.sketch.modify.drawn import at, measures, number, refused, run, sketch, state


@pytest.mark.parametrize(
    ("line", "handle", "place"),
    [
        ("drag L0.p1 5,3", "L0.p1", (5, 3)),
        ("drag L0.p2 @0,3", "L0.p2", (4, 3)),
        ("drag L0 @2,0", "L0.p1", (2, 0)),
        ("drag L0 2,5", "L0.p2", (4, 5)),
        ("drag A0.center 0,0", "A0.center", (0, 0)),
        ("drag A0.start @-1,2", "A0.start", (19, 2)),
        ("drag A0 @0,1", "A0.end", (18, 1)),
        ("drag P0 3,3", "P0", (3, 3)),
        ("drag P0 @3,3", "P0", (10, 10)),
        ("drag A1 @1,1", "A1.center", (31, 31)),
        ("drag EA0 0,0", "EA0.center", (0, 0)),
        ("drag S0 @1,1", "S0.p2", (54, 51)),
    ],
)
def test_forms(line: str, handle: str, place: tuple[float, float]) -> None:
    session = sketch(
        "add_line 0,0 4,0; add_arc 20,0 18,0 19,1; add_point 7,7; add_circle 30,30 2;"
        "add_ellipse 40,40 3 2 0; add_spline 50,50 51,52 52,48 53,50"
    )
    before, steps = state(session), session.document.history.position
    reply = run(session, line)
    assert at(session, handle) == pytest.approx(place, abs=1e-6)
    assert reply.data["reached"]
    assert session.document.history.position == steps + 1
    session.run("undo")
    assert state(session) == before


def test_a_body_keeps_its_shape() -> None:
    session = sketch("add_arc 2,0 0,2 1.4142135623730951,1.4142135623730951; add_line 9,9 12,13")
    run(session, "drag A0 @0,1")
    assert number(session, "A0.radius") == pytest.approx(2)
    assert number(session, "A0.sweep") == pytest.approx(90)
    run(session, "drag L0 @1,1")
    assert number(session, "L0.length") == pytest.approx(5)


def test_constraints_hold_exactly_and_what_is_out_of_reach_is_said() -> None:
    session = sketch("add_line 0,0 5,0; lock L0.p1 0,0; length L0 5")
    reply = run(session, "drag L0.p2 0,20")
    assert at(session, "L0.p2") == pytest.approx((0, 5), abs=1e-5)
    assert not reply.data["reached"] and "not to (0, 20)" in reply.text
    assert measures(session, "d0") == pytest.approx(5, abs=1e-9)


def test_the_rest_of_the_sketch_follows() -> None:
    session = sketch("add_rect 0,0 5,3 hv; length L0 5; length L1 3")
    reply = run(session, "drag L0.p1 @1,1")
    assert at(session, "L2.p1") == pytest.approx((6, 4))
    assert set(reply.data["moved"]) == {"L0", "L1", "L2", "L3"}


def test_a_defined_sketch_stays_where_it_is() -> None:
    session = sketch("add_rect 0,0 5,3 hv; length L0 5; length L1 3; lock L0.p1 0,0")
    before = session.document.values.copy()
    assert not run(session, "drag L2.p1 9,9").data["reached"]
    assert session.document.values == pytest.approx(before, abs=1e-9)


@pytest.mark.parametrize(
    ("line", "code", "shown"),
    [
        ("drag", "E1251", "drag"),
        ("drag L0", "E1251", "drag L0"),
        ("drag L9 1,1", "E1201", "L9"),
        ("drag L0.p9 1,1", "E1202", "L0.p9"),
        ("drag L0.p1 5", "E1253", "5"),
        ("drag L0.p1 1,1 2", "E1252", "2"),
        ("drag d0 1,1", "E1256", "d0"),
    ],
)
def test_refusals_name_the_word_and_change_nothing(line: str, code: str, shown: str) -> None:
    session = sketch("add_line 0,0 5,0; length L0 5")
    assert refused(session, line)[0::2] == (code, shown)


def test_frames_of_a_drag_are_kept_as_one_change() -> None:
    session = sketch("add_line 0,0 4,0; add_line 9,9 12,13")
    document = session.document
    with document.transaction("outer"):
        session.editor.drag({"L1.p1": (8.0, 8.0)})
        before = state(session)
        with pytest.raises(KeyError), session.editor.dragging(["L1.p1"]) as drag:
            for k in range(20):
                drag.by(0.1 * (k + 1), 0.2 * (k + 1))
            assert document.open_transaction is not None
            assert len(document.open_transaction.changes) <= 3
            raise KeyError
        assert state(session) == before  # what was changed before the drag is not taken back
    session.run("undo")
    assert at(session, "L1.p1") == (9, 9)
