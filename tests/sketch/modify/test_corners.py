"""`fillet` and `chamfer`: every form, what follows the corner, and what is refused."""

from __future__ import annotations

import math

import pytest

from arael.diagnostics.records import AraelError
from tests.sketch.modify.drawn import at, kinds, measures, number, refused, run, sketch, state

RECT = "add_rect 0,0 5,3 hv"


@pytest.mark.parametrize("form", ["L0 L1 0.5", "L0.p2 0.5", "L1.p1 0.5", "L1 L0 0.5"])
def test_a_corner_is_rounded_by_either_form(form: str) -> None:
    session = sketch(RECT)
    reply = run(session, f"fillet {form}")
    assert reply.names == ("A0",) and reply.text.startswith("Filleted 1 of 1 corners")
    assert at(session, "L0.p2") == pytest.approx((4.5, 0))
    assert at(session, "L1.p1") == pytest.approx((5, 0.5))
    assert at(session, "A0.center") == pytest.approx((4.5, 0.5))
    assert number(session, "A0.sweep") == pytest.approx(90)
    found = kinds(session)
    assert ("coincident", ("L1.p1", "L0.p2")) not in found
    assert {("tangent", ("L0", "A0")), ("tangent", ("L1", "A0"))} <= set(found)
    assert measures(session, "d0") == pytest.approx(0.5)


def test_the_arc_is_where_the_formulas_put_it() -> None:
    session = sketch("add_line 0,0 10,0; add_line 0,0 6,8")
    run(session, "fillet L0 L1 1")
    theta = math.atan2(8, 6)
    trim, far = 1 / math.tan(theta / 2), 1 / math.sin(theta / 2)
    assert at(session, "L0.p1") == pytest.approx((trim, 0))
    assert math.hypot(*at(session, "A0.center")) == pytest.approx(far)


def test_keywords_leave_tangents_and_the_radius_out() -> None:
    session = sketch(RECT)
    run(session, "fillet L0 L1 0.5 noradius notangent")
    assert not session.document.dimensions
    assert "tangent" not in [kind for kind, _ in kinds(session)]


def test_the_first_corner_carries_the_expression_and_the_others_its_name() -> None:
    session = sketch(RECT + "; param r 0.25")
    reply = run(session, "fillet L0 L1 L1.p2 L2 L3 L3 L0 2*r")
    assert reply.names == ("A0", "A1", "A2", "A3")
    texts = [one.value.text for one in session.document.dimensions.values() if one.value]
    assert texts == ["2*r", "d0", "d0", "d0"]
    session.run("param r 0.3")
    for name in reply.names:
        assert number(session, f"{name}.radius") == pytest.approx(0.6)


def test_corners_that_cannot_be_rounded_are_listed_and_the_others_are() -> None:
    session = sketch(RECT + "; add_line 9,9 9.1,9; add_line 9.1,9 9.1,9.1")
    reply = run(session, "fillet L4 L5 L0 L1 L0 L2 0.5")
    assert reply.text.startswith("Filleted 1 of 3 corners")
    assert "L4 L5: FAILED: L4 is 0.1 long" in reply.text
    assert "L0 L2: FAILED: L0 and L2 share no corner" in reply.text
    assert session.document.dimensions["d0"].value.text == "0.5"  # type: ignore[union-attr]
    assert len(session.document.entities) == 7


def test_what_is_said_of_the_corner_and_of_full_lengths_goes_to_a_point_that_stays() -> None:
    session = sketch(
        RECT + "; length L0 5; length L1 3; lock L0.p1 0,0; add_line 5,0 9,0;"
        "param w L0.length; param x L0.p2.x; add_point 1,1; midpoint P0 L0"
    )
    reply = run(session, "fillet L0 L1 0.5")
    assert at(session, "P1") == pytest.approx((5, 0))
    assert session.document.dimensions["d0"].args == ("L0.p1", "P1")
    assert session.document.dimensions["d1"].args == ("L1.p2", "P1")
    assert measures(session, "d0") == pytest.approx(5)
    assert measures(session, "d1") == pytest.approx(3)
    assert ("coincident", ("L4.p1", "P1")) in kinds(session)
    assert ("symmetry", ("L0.p1", "P0", "P1")) in kinds(session)
    assert at(session, "P0") == pytest.approx((2.5, 0))
    parameters = session.document.parameters
    assert parameters["w"].amount.number == pytest.approx(5)
    assert parameters["x"].amount.text == "P1.x"
    assert {"d0", "d1"} <= set(reply.data["moved"])
    session.run("set_driven d0 7")
    assert at(session, "L0.p2") == pytest.approx((6.5, 0))
    assert at(session, "P0") == pytest.approx((3.5, 0))


def test_nothing_that_was_measured_changes_and_no_freedom_is_left() -> None:
    session = sketch(RECT + "; length L0 5; length L1 3; lock L0.p1 0,0")
    run(session, "fillet L0 L1 L1 L2 L2 L3 L3 L0 0.5")
    assert run(session, "dof").text.startswith("0 ")
    assert measures(session, "d0") == pytest.approx(5)
    assert measures(session, "d1") == pytest.approx(3)


def test_equal_lengths_stay_where_they_still_hold() -> None:
    session = sketch("add_rect 0,0 4,4 hv; equal L0 L1")
    reply = run(session, "fillet L0 L1 L1 L2 L2 L3 L3 L0 0.5")
    assert "C4" in session.document.constraints and "C4" not in reply.data["dropped"]
    assert session.document.constraints["C4"].active
    session = sketch("add_rect 0,0 4,4 hv; equal L0 L1")
    reply = run(session, "fillet L1 L2 0.5")
    assert "C4" in reply.data["dropped"] and "C4" not in session.document.constraints
    assert number(session, "L0.length") == pytest.approx(4)


def test_an_outline_that_is_only_measured_runs_over_the_arc() -> None:
    session = sketch(RECT + "; area L0 L1 L2 L3 derived")
    run(session, "fillet L0 L1 1")
    assert session.document.dimensions["d0"].args == ("L0", "A0", "L1", "L2", "L3")
    assert measures(session, "d0") == pytest.approx(15 - (1 - math.pi / 4))


# --- chamfer --------------------------------------------------------------------------------


def test_a_chamfer_keeps_the_corner_as_a_point_on_both_lines() -> None:
    session = sketch(RECT)
    reply = run(session, "chamfer L0 L1 0.5")
    assert reply.names == ("L4",)
    assert at(session, "L4.p1") == pytest.approx((4.5, 0))
    assert at(session, "L4.p2") == pytest.approx((5, 0.5))
    assert at(session, "P0") == pytest.approx((5, 0))
    assert {("point_on", ("P0", "L0")), ("point_on", ("P0", "L1"))} <= set(kinds(session))
    values = [one.value.text for one in session.document.dimensions.values() if one.value]
    assert values == ["0.5", "d0"]


def test_all_legs_follow_the_first_dimension() -> None:
    session = sketch(RECT + "; param c 0.5")
    run(session, "chamfer L0 L1 L1.p2 c")
    values = [one.value.text for one in session.document.dimensions.values() if one.value]
    assert values == ["c", "d0", "d0", "d2"]
    session.run("param c 0.75")
    for name in ("d0", "d1", "d2", "d3"):
        assert measures(session, name) == pytest.approx(0.75)


def test_lengths_go_to_the_corner_point_of_a_chamfer() -> None:
    session = sketch(RECT + "; length L0 5; length L1 3; lock L0.p1 0,0")
    run(session, "chamfer L0 L1 L1 L2 0.5")
    assert run(session, "dof").text.startswith("0 ")
    assert measures(session, "d0") == pytest.approx(5)
    assert measures(session, "d1") == pytest.approx(3)


@pytest.mark.parametrize("word", ["fillet", "chamfer"])
def test_a_corner_is_one_step_of_undo_and_comes_back_bit_by_bit(word: str) -> None:
    session = sketch(RECT + "; length L0 5; lock L0.p2; equal L1 L3 force; param w L0.length")
    before, steps = state(session), session.document.history.position
    run(session, f"{word} L0 L1 L1 L2 0.5")
    assert session.document.history.position == steps + 1
    session.run("undo")
    assert state(session) == before


@pytest.mark.parametrize("word", ["fillet", "chamfer"])
@pytest.mark.parametrize(
    ("rest", "code", "shown"),
    [
        ("", "E1251", None),
        ("0.5", "E1251", None),
        ("L0 0.5", "E1251", "L0"),
        ("L0 L1", "E1251", None),
        ("L0 L1 0", "E1257", "0"),
        ("L0 L1 -2", "E1257", "-2"),
        ("L0 L1 9", "E1283", None),
        ("L0 L2 0.5", "E1283", "L0"),
        ("L0 A0 0.5", "E1256", "A0"),
        ("A0.center 0.5", "E1256", "A0.center"),
        ("L9 L1 0.5", "E1201", "L9"),
        ("L4.p2 0.5", "E1283", "L4.p2"),
        ("L4 L5 0.5", "E1283", "L4"),
        ("L6.p2 0.1", "E1283", "L6.p2"),
        ("L9.p2 0.1", "E1201", "L9.p2"),
        ("L0 L1 0.5 loud", "E1256", "0.5"),
    ],
)
def test_refusals_name_the_word(word: str, rest: str, code: str, shown: str | None) -> None:
    session = sketch(
        RECT + "; add_circle 9,9 1; add_line 20,0 22,0; add_line 22,0 25,0; add_line 30,0 32,0;"
        "add_point 32,0; add_line 32,0 32,5 noconnect; coincident L7.p1 P0"
    )
    found = refused(session, f"{word} {rest}".strip())
    assert found[0] == code
    if shown is not None:
        assert found[2] == shown


@pytest.mark.parametrize(("word", "most"), [("fillet", 3 * math.tan(math.pi / 8)), ("chamfer", 3)])
def test_a_size_that_is_too_large_names_the_largest_that_fits(word: str, most: float) -> None:
    """A corner of 45 degrees between lines of 5 and 3."""
    s = 3 / math.sqrt(2)
    session = sketch(f"add_line 0,0 5,0; add_line 5,0 {5 - s},{s}")
    with pytest.raises(AraelError) as caught:
        session.run(f"{word} L0 L1 4")
    assert caught.value.diagnostics[0].help == (f"a size below {most:.6g} fits",)
    run(session, f"{word} L0 L1 {most * 0.999}")


def test_an_end_where_three_lines_meet_names_two_corners() -> None:
    session = sketch("add_line 0,0 5,0; add_line 5,0 5,5; add_line 5,0 9,1")
    code, message, _ = refused(session, "fillet L0.p2 0.5")
    assert code == "E1283" and "names 2 corners" in message
