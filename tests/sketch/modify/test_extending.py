"""`extend`: ends, targets, dimensions of the length, refusals."""

from __future__ import annotations

import pytest

from tests.sketch.modify.drawn import at, kinds, measures, refused, run, sketch, state

BETWEEN = "add_line 0,0 2,0; add_line 5,-1 5,4; add_line -4,-1 -4,1; add_line 7,-1 7,1"


@pytest.mark.parametrize(
    ("words", "end", "place", "other"),
    [
        ("to L1", "p2", (5, 0), "L1"),
        ("to L2", "p1", (-4, 0), "L2"),
        ("to L3", "p2", (7, 0), "L3"),
        ("forward", "p2", (5, 0), "L1"),
        ("backward", "p1", (-4, 0), "L2"),
        ("to L2 backward", "p1", (-4, 0), "L2"),
        ("9,1", "p2", (5, 0), "L1"),
        ("-1,1", "p1", (-4, 0), "L2"),
    ],
)
def test_forms(words: str, end: str, place: tuple[float, float], other: str) -> None:
    session = sketch(BETWEEN)
    before, steps = state(session), session.document.history.position
    reply = run(session, f"extend L0 {words}")
    assert reply.data["end"] == end
    assert at(session, f"L0.{end}") == pytest.approx(place)
    assert ("point_on", (f"L0.{end}", other)) in kinds(session)
    assert session.document.history.position == steps + 1
    session.run("undo")
    assert state(session) == before


def test_nopin_leaves_the_end_free() -> None:
    session = sketch(BETWEEN)
    run(session, "extend L0 to L1 nopin")
    assert not session.document.constraints


def test_a_literal_length_gets_its_new_value_and_an_expression_only_measures() -> None:
    session = sketch(BETWEEN + "; length L0 2")
    assert run(session, "extend L0 to L1").data["changed"] == ["d0"]
    assert at(session, "L0.p1") == pytest.approx((0, 0))
    assert measures(session, "d0") == pytest.approx(5)
    assert not session.document.dimensions["d0"].derived
    session = sketch(BETWEEN + "; param w 2; length L0 w")
    run(session, "extend L0 to L1")
    assert session.document.dimensions["d0"].derived
    assert at(session, "L0.p2") == pytest.approx((5, 0))


def test_an_arc_goes_on_along_its_circle() -> None:
    session = sketch("add_arc 2,0 0,2 1.4142135623730951,1.4142135623730951; add_line -3,0 -1,0")
    run(session, "extend A0 to L0")
    assert at(session, "A0.end") == pytest.approx((-2, 0))
    session.run("undo")
    run(session, "extend A0 to L0 backward")
    assert at(session, "A0.start") == pytest.approx((-2, 0))


def test_an_arc_drawn_clockwise_goes_on_at_its_end() -> None:
    session = sketch("add_arc 0,2 2,0 1.4142135623730951,1.4142135623730951; add_line 0,-3 0,-1")
    run(session, "extend A0 forward")
    assert at(session, "A0.end") == pytest.approx((0, -2))
    assert at(session, "A0.start") == pytest.approx((0, 2))


@pytest.mark.parametrize(
    ("line", "code", "shown"),
    [
        ("extend", "E1251", "extend"),
        ("extend L0", "E1251", "extend L0"),
        ("extend L0 to", "E1251", "extend L0 to"),
        ("extend L0 to L0", "E1281", "L0"),
        ("extend L0 to L2 forward", "E1281", "L2"),
        ("extend L2 to L0", "E1281", "L0"),
        ("extend A0 to L0", "E1284", "A0"),
        ("extend P0 to L0", "E1256", "P0"),
        ("extend L0 forward backward", "E1267", "extend L0 forward backward"),
        ("extend L0 to L1 3", "E1252", "3"),
        ("extend L9 to L0", "E1201", "L9"),
    ],
)
def test_refusals_name_the_word_and_change_nothing(line: str, code: str, shown: str) -> None:
    session = sketch(BETWEEN + "; add_circle 20,20 1; add_point 9,9")
    assert refused(session, line)[0::2] == (code, shown)
