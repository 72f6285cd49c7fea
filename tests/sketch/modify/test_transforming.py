"""`scale`, `rotate`, `move`: geometry, dimensions that follow, those that are left, refusals."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.sketch.modify.drawn import at, kinds, measures, number, refused, run, sketch, state

RECT = "add_rect 0,0 5,3 hv; length L0 5; length L1 3; lock L0.p1 0,0"
ALL = "L0 L1 L2 L3"


@pytest.mark.parametrize("factor", [0.001, 0.5, 1, 2, 1000])
def test_a_dimensioned_rectangle_scales_with_its_dimensions_and_lock(factor: float) -> None:
    session = sketch(RECT)
    before = session.document.values.copy()
    reply = run(session, f"scale {ALL} about 1,1 {factor}")
    c = np.array([1.0, 1.0] * 8)
    assert np.allclose(session.document.values, c + factor * (before - c), rtol=1e-9, atol=1e-9)
    assert measures(session, "d0") == pytest.approx(5 * factor)
    if factor != 1:
        assert reply.data["dims_changed"] == ["d0", "d1"]
        assert "dims scaled: d0" in reply.text
    assert session.document.constraints["C4"].numbers == pytest.approx((1 - factor, 1 - factor))


def test_radii_and_ranges_scale_and_angles_stay() -> None:
    session = sketch(
        "add_circle 1,1 2; add_ellipse 5,5 3 2 30; add_arc 9,0 11,0 10,1; radius A0 1 to 4;"
        "radius EA0 3; radius_b EA0 2; sweep A1 180; xangle EA0 30; lock A0.center"
    )
    reply = run(session, "scale A0 EA0 A1 about 0,0 2")
    assert [number(session, f"EA0.{p}") for p in ("radius", "radius_b")] == pytest.approx([6, 4])
    assert number(session, "A1.sweep") == pytest.approx(180)
    one = session.document.dimensions["d0"]
    assert one.low is not None and one.high is not None
    assert (one.low.number, one.high.number) == (2, 8)
    assert reply.data["dims_changed"] == ["d0", "d1", "d2"]


def test_what_cannot_follow_is_left_and_listed_with_a_reason() -> None:
    session = sketch(
        RECT + "; param w 4; add_line 20,0 24,0; length L4 w; add_line 20,5 25,5;"
        "param top 9; length L5 1 to top; distance L4.p1 L0.p1 20"
    )
    reply = run(session, "scale L4 L5 about L4.p1 1.5")
    left = reply.data["dims_left"]
    assert "expression" in left["d2"] and "bound" in left["d3"]
    assert left["d4"] == "it spans geometry that stays"
    assert session.document.dimensions["d2"].value.text == "w"  # type: ignore[union-attr]
    assert measures(session, "d2") == pytest.approx(4)
    assert measures(session, "d4") == pytest.approx(20)
    assert "dims left: d2" in reply.text


def test_points_the_selection_and_expressions_as_factors() -> None:
    session = sketch("add_point 1,0; add_point 0,2; param w 4; add_point 7,7")
    session.run("select P0 P1; scale selection about 0,0 w/2")
    assert at(session, "P0") == pytest.approx((2, 0))
    assert at(session, "P1") == pytest.approx((0, 4))
    assert at(session, "P2") == pytest.approx((7, 7))


def test_a_connected_neighbour_follows_with_its_end() -> None:
    session = sketch("add_line 0,0 2,0; add_line 2,0 2,5")
    run(session, "scale L0 about 0,0 2")
    assert at(session, "L0.p2") == pytest.approx((4, 0))
    assert at(session, "L1.p1") == pytest.approx((4, 0))
    assert at(session, "L1.p2") == pytest.approx((2, 5))


def test_a_quarter_turn_exchanges_the_axes() -> None:
    session = sketch(
        "add_rect 0,0 5,3 hv; lock L0.p1 0,0; hdistance L0.p1 L2.p1 5; vdistance L0.p1 L2.p1 3"
    )
    run(session, f"rotate {ALL} about 0,0 90")
    assert at(session, "L2.p1") == pytest.approx((-3, 5))
    assert {"CL0V", "CL1H", "CL2V", "CL3H"} <= set(session.document.constraints)
    assert session.document.dimensions["d0"].kind == "vdistance"
    assert session.document.dimensions["d1"].kind == "hdistance"
    assert measures(session, "d0") == pytest.approx(5)
    assert run(session, "dof").text.startswith("0 ")
    run(session, f"rotate {ALL} about 0,0 -90")
    assert at(session, "L2.p1") == pytest.approx((5, 3))


def test_another_angle_keeps_the_shape_and_frees_the_axes() -> None:
    session = sketch(RECT)
    reply = run(session, f"rotate {ALL} about 0,0 30")
    assert reply.data["dropped"] == ["CL0H", "CL1V", "CL2H", "CL3V"]
    c, s = math.cos(math.pi / 6), math.sin(math.pi / 6)
    assert at(session, "L2.p1") == pytest.approx((5 * c - 3 * s, 5 * s + 3 * c))
    assert ("perpendicular", ("L0", "L1")) in kinds(session)
    assert ("parallel", ("L0", "L2")) in kinds(session)
    assert run(session, "dof").text.startswith("1 ")  # it can turn now


def test_angles_from_the_axis_follow_a_turn_and_distances_along_axes_only_measure() -> None:
    session = sketch(
        "add_line 0,0 4,0; add_point 2,2; add_ellipse 0,0 3 1 0; xangle L0 0; xangle EA0 0;"
        "hdistance L0.p1 L0.p2 4"
    )
    reply = run(session, "rotate L0 EA0 P0 about 0,0 30 deg")
    assert [measures(session, n) for n in ("d0", "d1")] == pytest.approx([30, 30])
    assert number(session, "EA0.rotation") == pytest.approx(30)
    assert session.document.dimensions["d2"].derived
    assert "derived" in reply.data["dims_left"]["d2"]


def test_move_by_a_vector_and_from_place_to_place() -> None:
    session = sketch(RECT + "; add_circle 2,2 1")
    run(session, f"move {ALL} A0 @1,2")
    assert at(session, "L0.p1") == pytest.approx((1, 2))
    assert session.document.constraints["C4"].numbers == (1, 2)
    assert at(session, "A0.center") == pytest.approx((3, 4))
    run(session, "move A0 from A0.center to L0.p1")
    assert at(session, "A0.center") == pytest.approx((1, 2))
    session.run("deselect; select A0; move selection @1,0")
    assert at(session, "A0.center") == pytest.approx((2, 2))


def test_splines_and_arcs_move_whole() -> None:
    session = sketch("add_spline 0,0 1,2 2,-2 3,0; add_arc 5,0 7,0 6,1; sweep A0 180")
    before = session.document.values.copy()
    run(session, "move S0 A0 @10,20")
    shift = np.array([10.0, 20.0] * 7)
    assert np.allclose(session.document.values[:14], before[:14] + shift)
    assert number(session, "A0.radius") == pytest.approx(1)


@pytest.mark.parametrize(
    "line",
    [f"scale {ALL} about 0,0 2", f"rotate {ALL} about 1,1 33", f"rotate {ALL} about 1,1 90",
     f"move {ALL} @3,4"],
)  # fmt: skip
def test_one_step_of_undo_bit_by_bit(line: str) -> None:
    session = sketch(RECT + "; add_circle 9,9 1")
    before, steps = state(session), session.document.history.position
    run(session, line)
    assert session.document.history.position == steps + 1
    session.run("undo")
    assert state(session) == before


@pytest.mark.parametrize(
    ("line", "code", "shown"),
    [
        ("scale", "E1251", "scale"),
        ("scale L0", "E1251", "scale L0"),
        ("scale about 0,0 2", "E1251", "scale"),
        ("scale L0 about", "E1251", None),
        ("scale L0 about 0,0", "E1251", None),
        ("scale L0 about 0,0 0", "E1257", "0"),
        ("scale L0 about 0,0 -1", "E1257", "-1"),
        ("scale L0 about 0,0 2 3", "E1252", "3"),
        ("scale L0.p1 about 0,0 2", "E1256", "L0.p1"),
        ("scale L9 about 0,0 2", "E1201", "L9"),
        ("scale selection about 0,0 2", "E1259", "selection"),
        ("scale L0 about 5 2", "E1253", "5"),
        ("rotate L0 30", "E1256", "30"),
        ("rotate L0 about 0,0", "E1251", None),
        ("rotate L0 about 0,0 3 mm", "E1261", "3 mm"),
        ("move L0", "E1251", None),
        ("move @1,1", "E1251", None),
        ("move L0 1,1", "E1256", "1,1"),
        ("move L0 from 0,0", "E1251", None),
        ("move L0 from 0,0 by 1,1", "E1252", "by"),
        ("move L0 @1,1 2", "E1252", "2"),
    ],
)
def test_refusals_name_the_word_and_change_nothing(line: str, code: str, shown: str) -> None:
    session = sketch("add_line 0,0 5,0")
    found = refused(session, line)
    assert found[0] == code
    if shown is not None:
        assert found[2] == shown


def test_geometry_that_the_rest_holds_back_is_refused_or_solved_exactly() -> None:
    session = sketch(RECT)
    run(session, "move L0 @1,0")  # tied to the others: everything still holds
    assert measures(session, "d0") == pytest.approx(5)
    assert measures(session, "d1") == pytest.approx(3)
