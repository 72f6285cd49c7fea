"""`split` and `trim`: every form, what follows the pieces, and what is refused."""

from __future__ import annotations

import pytest

from tests.sketch.modify.drawn import at, kinds, measures, number, refused, run, sketch, state

CROSS = "add_line 0,0 10,0; add_line 4,-2 4,3; add_line 8,-2 8,3"


def test_a_line_is_cut_at_every_crossing_with_the_cutters() -> None:
    session = sketch(CROSS)
    reply = run(session, "split L0 by L1 L2")
    assert reply.names == ("L3", "L4", "L5")
    assert "L0" not in session.document.entities
    assert [number(session, f"{n}.length") for n in reply.names] == pytest.approx([4, 4, 2])
    assert ("coincident", ("L3.p2", "L4.p1")) in kinds(session)
    assert ("point_on", ("L3.p2", "L1")) in kinds(session)
    assert ("point_on", ("L4.p2", "L2")) in kinds(session)


def test_a_coordinate_cuts_at_the_crossings_around_it() -> None:
    session = sketch(CROSS + "; add_line 9,-2 9,3")
    assert run(session, "split L0 5,1").names == ("L4", "L5", "L6")
    assert number(session, "L6.length") == pytest.approx(2)


def test_a_coordinate_beyond_the_last_crossing_cuts_once() -> None:
    session = sketch(CROSS)
    assert run(session, "split L0 9,0").names == ("L3", "L4")
    assert at(session, "L4.p1") == pytest.approx((8, 0))


def test_a_search_radius_bounds_the_distance_of_the_coordinate() -> None:
    session = sketch(CROSS)
    code, message, shown = refused(session, "split L0 5,1 0.5")
    assert (code, shown) == ("E1280", "5,1") and "1 away" in message
    assert len(run(session, "split L0 5,1 1.5").names) == 3


def test_pieces_are_captured_so_that_one_can_be_deleted() -> None:
    session = sketch(CROSS)
    session.run("a, b = split L0 by L1\ndelete b")
    assert list(session.document.entities) == ["L1", "L2", "L3"]


def test_nopin_leaves_the_cut_free() -> None:
    session = sketch(CROSS)
    run(session, "split L0 by L1 nopin")
    assert "point_on" not in [kind for kind, _ in kinds(session)]


def test_ends_go_to_the_piece_that_owns_them() -> None:
    session = sketch(CROSS + "; add_line 0,0 0,5; lock L0.p2; add_point 5,5; distance P0 L0.p2 9")
    reply = run(session, "split L0 by L1")
    assert ("coincident", ("L3.p1", "L4.p1")) in kinds(session)
    assert ("lock", ("L5.p2",)) in kinds(session)
    assert session.document.dimensions["d0"].args == ("P0", "L5.p2")
    assert measures(session, "d0") == pytest.approx(9)
    assert {"C0", "C1", "d0"} <= set(reply.data["moved"])


def test_directions_hold_for_every_piece() -> None:
    session = sketch(CROSS + "; xangle L0 0")
    run(session, "split L0 by L1")
    angles = [one for one in session.document.dimensions.values() if one.kind == "xangle"]
    assert [one.args for one in angles] == [("L3",), ("L4",)]
    session = sketch(CROSS + "; horizontal L0; add_line 0,5 9,5; parallel L0 L3")
    reply = run(session, "split L0 by L1")
    assert session.document.constraints["CL4H"].args == ("L4",)
    assert session.document.constraints["CL5H"].args == ("L5",)
    assert reply.data["copied"]["CL5H"] == "CL4H"
    copies = [args for kind, args in kinds(session) if kind == "parallel"]
    assert ("L4", "L3") in copies


def test_a_length_becomes_the_distance_of_the_ends() -> None:
    session = sketch(CROSS + "; length L0 10")
    run(session, "split L0 by L1")
    one = session.document.dimensions["d0"]
    assert (one.kind, one.args) == ("distance", ("L3.p1", "L4.p2"))
    assert measures(session, "d0") == pytest.approx(10)


def test_expressions_read_the_pieces() -> None:
    session = sketch(CROSS + "; param w L0.length/2; param x L0.p2.x; length L2 w")
    reply = run(session, "split L0 by L1")
    parameters = session.document.parameters
    assert parameters["w"].amount.text == "(L3.length + L4.length)/2"
    assert parameters["x"].amount.text == "L4.p2.x"
    assert parameters["w"].amount.number == pytest.approx(5)
    assert measures(session, "d0") == pytest.approx(5)
    assert set(reply.data["rewritten"]) == {"w", "x"} and not reply.data["broken"]


def test_what_means_the_whole_is_dropped_and_listed() -> None:
    session = sketch(CROSS + "; add_line 0,7 10,7; equal L0 L3; add_point 5,0; midpoint P0 L0")
    reply = run(session, "split L0 by L1")
    assert set(reply.data["dropped"]) == {"C0", "C1"}
    assert "dropped: C0: equal L0 L3" in reply.text


def test_a_point_on_the_line_goes_to_the_piece_it_lies_on() -> None:
    session = sketch(CROSS + "; add_point 7,0; point_on P0 L0; add_point 1,0; point_on P1 L0")
    run(session, "split L0 by L1")
    assert ("point_on", ("P0", "L4")) in kinds(session)
    assert ("point_on", ("P1", "L3")) in kinds(session)


def test_a_tangent_goes_to_the_piece_at_the_contact() -> None:
    session = sketch(CROSS + "; add_circle 6,1 1; tangent L0 A0")
    run(session, "split L0 by L1")
    assert ("tangent", ("L4", "A0")) in kinds(session)


def test_what_looks_like_construction_stays_construction() -> None:
    session = sketch(CROSS + "; constr L0; quiet L0; style L0 dashed")
    run(session, "split L0 by L1")
    for name in ("L3", "L4"):
        entity = session.document.entities[name]
        assert (entity.construction, entity.quiet, entity.style) == (True, True, "dashed")


def test_a_circle_is_cut_into_arcs_with_one_centre_and_radius() -> None:
    session = sketch("add_circle 0,0 2; add_line -3,0 3,0; radius A0 2; lock A0.center")
    reply = run(session, "split A0 by L0")
    assert reply.names == ("A1", "A2")
    assert sum(number(session, f"{n}.sweep") for n in reply.names) == pytest.approx(360)
    assert ("concentric", ("A1", "A2")) in kinds(session)
    assert ("lock", ("A1.center",)) in kinds(session)
    assert reply.data["copied"] == {"d1": "d0"}
    session.run("radius A1 2.5")
    assert number(session, "A2.radius") == pytest.approx(2.5)
    assert session.document.dimensions["d1"].derived  # it follows from the first piece's


def test_a_closed_curve_needs_two_crossings() -> None:
    session = sketch("add_circle 0,0 2; add_line 0,0 3,0")
    assert refused(session, "split A0 by L0")[0::2] == ("E1282", "A0")
    assert refused(session, "trim A0 -2,0")[0] == "E1282"


def test_an_arc_drawn_clockwise_keeps_its_direction() -> None:
    session = sketch("add_arc 2,0 -2,0 0,-2; add_line 0,-3 0,0; sweep A0 180")
    assert session.document.entities["A0"].clockwise
    reply = run(session, "split A0 by L0")
    assert at(session, "A1.start") == pytest.approx((2, 0))
    assert at(session, "A1.end") == pytest.approx((0, -2))
    assert at(session, "A2.end") == pytest.approx((-2, 0))
    assert ("coincident", ("A1.end", "A2.start")) in kinds(session)
    assert set(reply.data["dropped"]) == {"d0"}
    session.run("undo")
    run(session, "trim A0 by L0 forward")
    assert at(session, "A1.start") == pytest.approx((2, 0))
    assert at(session, "A1.end") == pytest.approx((0, -2))


def test_ellipses_are_cut_into_elliptic_arcs() -> None:
    session = sketch("add_ellipse 0,0 3 2 0; add_line -4,0 4,0; radius EA0 3; xangle EA0 0")
    reply = run(session, "split EA0 1,5")
    assert [session.document.entities[n].kind for n in reply.names] == ["earc", "earc"]
    assert len(reply.data["copied"]) == 2


def test_splines_go_on_smoothly_over_the_cut() -> None:
    session = sketch("add_spline 0,0 1,2 2,-2 3,0; add_line 0,0.25 4,0.25")
    reply = run(session, "split S0 by L0")
    assert len(reply.names) == 3
    assert ("tangent", ("S1.p2", "S2.p1")) in kinds(session)


def test_a_chain_has_all_pieces() -> None:
    session = sketch(CROSS + "; total_length L0 L1 15")
    run(session, "split L0 by L2")
    assert session.document.dimensions["d0"].args == ("L3", "L4", "L1")
    assert measures(session, "d0") == pytest.approx(15)


# --- trim -----------------------------------------------------------------------------------


def test_trim_deletes_the_stretch_at_the_coordinate() -> None:
    session = sketch(CROSS)
    assert run(session, "trim L0 6,0.1").names == ("L3", "L4")
    assert at(session, "L3.p2") == pytest.approx((4, 0))
    assert at(session, "L4.p1") == pytest.approx((8, 0))
    assert ("point_on", ("L4.p1", "L2")) in kinds(session)


def test_trim_with_nothing_that_crosses_deletes_the_entity() -> None:
    session = sketch("add_line 0,0 5,0; length L0 5")
    reply = run(session, "trim L0 1,1")
    assert not session.document.entities and "nothing crosses" in reply.text
    assert reply.data["deleted"] == ["L0", "d0"]


@pytest.mark.parametrize(
    ("words", "ends"),
    [
        ("by L1 forward", [(0, 4)]),
        ("by L1 backward", [(4, 10)]),
        ("by L1 L2", [(0, 4), (8, 10)]),
        ("by L2 L1 nopin", [(0, 4), (8, 10)]),
        ("9,0", [(0, 8)]),
        ("1,0 0.5", [(4, 10)]),
    ],
)
def test_forms_of_trim(words: str, ends: list[tuple[float, float]]) -> None:
    session = sketch(CROSS)
    names = run(session, f"trim L0 {words}").names
    found = [(at(session, f"{n}.p1")[0], at(session, f"{n}.p2")[0]) for n in names]
    assert found == [pytest.approx(one) for one in ends]


def test_a_cutter_that_crosses_twice() -> None:
    session = sketch("add_line -5,0 5,0; add_circle 0,0 2")
    assert run(session, "trim L0 by A0 forward").names == ("L1",)
    assert number(session, "L1.length") == pytest.approx(7)
    session.run("undo")
    assert run(session, "trim L0 by A0").names == ("L1", "L2")
    assert number(session, "L1.length") == pytest.approx(3)


def test_trim_of_a_circle_leaves_the_other_arc() -> None:
    session = sketch("add_circle 0,0 2; add_line -3,0 3,0; radius A0 2")
    run(session, "trim A0 0,9")
    assert number(session, "A1.sweep") == pytest.approx(180)
    assert at(session, "A1.start") == pytest.approx((-2, 0))
    assert measures(session, "d0") == pytest.approx(2)


def test_what_referred_to_a_lost_end_is_dropped_and_what_read_it_is_broken() -> None:
    session = sketch(CROSS + "; length L0 10; lock L0.p2; param w L0.length; param v L0.p1.x")
    reply = run(session, "trim L0 9,0")
    assert set(reply.data["dropped"]) == {"C0", "d0"}
    assert reply.data["broken"] == ["w"]
    assert session.document.parameters["w"].amount.number == 10
    assert session.document.parameters["v"].amount.text == "L3.p1.x"


def test_a_gap_in_the_middle_keeps_the_distance_of_the_ends() -> None:
    session = sketch(CROSS + "; length L0 10; add_line 0,5 5,5; length L3 L0.length/2")
    before = session.document.values.copy()
    run(session, "trim L0 6,0")
    assert measures(session, "d0") == pytest.approx(10)
    assert session.document.dimensions["d1"].value.text == "dist(L4.p1, L5.p2)/2"  # type: ignore[union-attr]
    assert measures(session, "d1") == pytest.approx(5)
    assert session.document.numbers_of("L3").tolist() == pytest.approx(before[12:16].tolist())


def test_a_cut_is_one_step_of_undo_and_comes_back_bit_by_bit() -> None:
    session = sketch(CROSS + "; length L0 10; horizontal L0; add_circle 6,1 1; tangent L0 A0")
    before = state(session)
    for line in ("split L0 by L1 L2", "trim L0 6,0", "trim L0 by L1 forward"):
        steps = session.document.history.position
        run(session, line)
        assert session.document.history.position == steps + 1
        session.run("undo")
        assert state(session) == before


@pytest.mark.parametrize(
    ("line", "code", "shown"),
    [
        ("split", "E1251", "split"),
        ("split P0 1,1", "E1256", "P0"),
        ("split L0.p1 1,1", "E1256", "L0.p1"),
        ("split L9 1,1", "E1201", "L9"),
        ("split L0", "E1251", "split L0"),
        ("split L0 by", "E1251", "split L0 by"),
        ("split L0 by L0", "E1281", "L0"),
        ("split L0 by L3", "E1281", "L3"),
        ("split L0 by L1 P0", "E1256", "P0"),
        ("split L3 1,20", "E1281", "1,20"),
        ("split L0 5,0 -1", "E1257", "-1"),
        ("split L0 5,0 1 1", "E1252", "1"),
        ("split L0 by L1 nopin nopin", "E1267", "nopin"),
        ("split L0 by L1 forward", "E1201", "forward"),
        ("trim L0 by L1", "E1281", "L1"),
        ("trim L0 by L1 L2 A0", "E1281", "A0"),
        ("trim L0 by L1 L2 forward", "E1281", "L2"),
        ("trim L0 5,0 forward", "E1252", "trim L0 5,0 forward"),
        ("trim L0 by L1 forward backward", "E1267", "trim L0 by L1 forward backward"),
        ("trim A0 by L0", "E1282", "A0"),
        ("trim L0 by L1 L4", "E1281", "L4"),
    ],
)
def test_refusals_name_the_word_and_change_nothing(line: str, code: str, shown: str) -> None:
    session = sketch(
        CROSS + "; add_line 0,20 5,20; add_point 3,3; add_circle 2,0 1; add_line 3,-1 5,1"
    )
    found = refused(session, line)
    if "split L0 by L1 forward" in line:
        assert found[0] in ("E1252", "E1256", "E1201")
    else:
        assert found[0::2] == (code, shown)


def test_an_expression_that_is_rewritten_is_solved_as_it_is_written_now() -> None:
    session = sketch("add_line 0,0 4,0; add_line 0,5 2,5; length L1 L0.length/2; add_line 0,8 6,8")
    session.run("length L1 L2.length/2")
    assert number(session, "L1.length") == pytest.approx(number(session, "L2.length") / 2)
    session.run("length L2 8")
    assert number(session, "L1.length") == pytest.approx(4)
