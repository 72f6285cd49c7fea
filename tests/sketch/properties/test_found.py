"""What random sketches brought to light, each as the shortest script that shows it."""

from __future__ import annotations

import re

import numpy as np
import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.commands.session import Session
from arael.sketch.geometry.feet import ellipse_feet
from arael.sketch.layout.chains import measured_area
from arael.sketch.layout.operands import operands
from tests.sketch.properties.generator import snapshot


def sketch(script: str) -> Session:
    session = Session()
    session.run(script)
    return session


def refused(session: Session, line: str) -> str:
    """Code of the refusal, which changes nothing."""
    before = snapshot(session.document)
    with pytest.raises(AraelError) as caught:
        session.run(line)
    assert snapshot(session.document) == before
    return caught.value.diagnostics[0].code


@pytest.mark.parametrize("line", ["sweep A0 90", "arc_length A0 3", "midpoint P0 A0"])
def test_a_circle_has_no_start_and_no_end(line: str) -> None:
    session = sketch("add_circle 0,0 2; add_point 5,5")
    assert refused(session, line) in ("E1222", "E1254")


def test_concentric_does_not_turn_a_tangent_circle_inside_out() -> None:
    session = sketch("add_arc -6.795,4.092 0.894,-5.588 5.956,0.332; add_circle 0.953,8.289 1.245")
    session.run("tangent A1 A0")
    # it would collapse, or the side of the tangent be lost
    assert refused(session, "concentric A1 A0") in ("E1220", "E1231", "E1233")


def test_a_circle_about_the_end_of_a_line_is_not_tangent_to_it() -> None:
    session = sketch("add_circle -9,2 0.5; add_line A0.center -3,-2.6")
    assert refused(session, "tangent L0 A0") == "E1231"  # with the coincidence


def test_an_arc_does_not_end_in_its_center_by_way_of_another_point() -> None:
    session = sketch("add_arc 5,0 0,5 3.5355339,3.5355339; add_point 5,0; add_line 5,0 9,9")
    assert refused(session, "coincident A0.center P0") == "E1231"  # with the start's


def test_the_size_of_points_in_one_place_is_that_of_what_is_around_them() -> None:
    session = sketch("add_point 3.5,5.6; add_point -8.5,-8.0; add_circle -1.5,-0.7 2")
    session.run("vertical P1 P0; horizontal A0.center P0; coincident P1 A0.center")
    assert session.editor.layout.size == pytest.approx(4.0)
    assert np.ptp(session.document.values) > 1.0


def test_ranges_of_directions() -> None:
    session = sketch("add_line 0,0 5,-0.001; xangle L0 >= 1.3")
    assert refused(session, "horizontal L0")  # 0 degrees, not 360


def test_what_touches_an_ellipse_does_not_creep_when_something_else_is_deleted() -> None:
    session = sketch("add_earc_center -1.097,-4.118 3.323 1.942 11.517 18.786 227.841")
    session.run("add_circle -6.739,5.259 0.576; add_circle -8.613,0.030 2.388")
    session.run("distance A0 A1 driven\ntangent A1 EA0\ndelete C0")
    before = snapshot(session.document)
    assert session.editor.solve().moved == ()
    assert snapshot(session.document) == before


def test_a_lock_that_adds_nothing_is_redundant() -> None:
    session = sketch("add_line 0,0 5,0\nlock L0.p1\nhorizontal L0\nlength L0 5")
    assert refused(session, "lock L0.p2") == "E1230"


def test_a_drag_leaves_something_of_a_line() -> None:
    session = sketch("add_line 0,0 5,0; lock L0.p2; horizontal L0")
    with session.editor.dragging(["L0.p1"]) as drag:
        for x in (2.0, 4.0, 4.9, 5.0, 5.0, 5.0):
            drag.to((x, 0.0))
    assert session.document.numbers_of("L0")[0] < 5.0 - 1e-8
    try:
        session.editor.drag({"L0.p1": (5.0, 0.0)})
    except AraelError as error:
        assert error.diagnostics[0].code == "E1220"
    assert session.document.numbers_of("L0")[0] < 5.0


def test_the_distance_of_an_arcs_center_from_a_line_is_not_that_of_two_arcs() -> None:
    session = sketch("add_arc 5,0 0,5 3.5355339,3.5355339; add_line 10,0 10,7")
    session.run("distance A0.center L0 4")
    assert session.editor.measure("distance", ("A0.center", "L0")) == pytest.approx(4.0)
    session.run("delete d0; distance A0.center L0 >= 6")
    assert session.editor.measure("distance", ("A0.center", "L0")) == pytest.approx(6.0)


SQUARE = "a, b, c, d = add_line 0,0 4,0 4,4 0,4 0,0\n"


def test_an_area_takes_the_curves_of_an_outline_in_any_order() -> None:
    session = sketch(SQUARE + "area a c b d 25")
    assert session.document.dimensions["d0"].args == ("L0", "L1", "L2", "L3")
    assert session.editor.measure("area", ("L0", "L1", "L2", "L3")) == pytest.approx(25.0)


@pytest.mark.parametrize(
    "line",
    ["area a b", "area a b c", "area a b c d A0", "area e f h"],
    ids=["open", "gap", "several", "not joined"],
)
def test_an_area_needs_a_closed_outline(line: str) -> None:
    session = sketch(SQUARE + "add_circle 2,2 1\ne, f = add_line 9,0 12,0 12,3")
    session.run("h = add_line 12,3 9,0 noconnect")
    assert refused(session, f"{line} 3") == "E1222"


def test_an_area_whose_outline_is_opened_only_measures() -> None:
    session = sketch(SQUARE + "area a b c d 25")
    (reply,) = session.run("delete C1")
    assert "`d0` only measures now" in reply.text
    assert session.document.dimensions["d0"].derived
    assert refused(session, "set_driven d0 20") == "E1222"
    assert refused(session, "set_driven d0") == "E1222"
    session.run("undo")
    assert not session.document.dimensions["d0"].derived


def test_the_area_of_an_outline_whose_side_is_split_is_that_of_all_pieces() -> None:
    # The pieces follow each other against the direction of the outline.
    session = sketch("a, b, c = add_line 0,0 4,0 0,3 0,0; lock a.p1 0,0; area a b c driven")
    session.run("add_line 1,1 9,4; add_line 1,2 9,7\nsplit b by L3 L4")
    args = session.document.dimensions["d0"].args
    assert len(args) == 5
    found = operands(session.document, args)
    assert measured_area(found, session.document.values) == pytest.approx(6.0)
    assert measured_area(found[:1:-1] + found[:2], session.document.values) == pytest.approx(6.0)


def test_the_side_of_circles_that_touched_in_a_joint_is_that_drawn_when_the_joint_goes() -> None:
    session = sketch("add_arc -3,0 3,0 0,3; add_circle 2,0 1; point_on A0.end A1")
    session.run("tangent A0 A1")  # inside, the arc is the larger
    session.run("radius A1 1\nradius A1 9\nlock A1.center")  # through equal radii
    before = session.document.values.copy()
    session.run("delete C0")
    assert session.editor.solver.left_open() == []
    assert session.editor.solve().moved == ()
    assert np.array_equal(session.document.values, before)


@pytest.mark.parametrize("radius", [3.0, 30.0, 300.0])
def test_an_ellipse_and_a_much_larger_circle_that_touch_do_so_when_laid_out_anew(
    radius: float,
) -> None:
    session = sketch(f"add_ellipse 0,0 3 1 20; add_circle {radius + 2.2},0.5 {radius}")
    session.run("tangent EA0 A0")
    from arael.sketch.editing.editor import Editor

    anew = Editor(session.document)
    assert anew.solver.left_open() == []
    assert anew.solve().moved == ()


def test_a_tangent_is_written_anew_when_a_point_in_its_joint_comes_onto_its_line() -> None:
    # C1 lies on the line; the arc's end is in its place through another tie only.
    session = sketch("add_line 0,0 9,0; add_arc 4,0 9,5 8,1.5; add_point 4,0")
    session.run("add_point 20,20; point_on P1 L0")
    session.run("tangent L0 A0")
    for line in ("coincident P1 P0", "delete C1", "undo", "undo", "redo"):
        session.run(line)
        session.editor.layout.check()


@pytest.mark.parametrize("y", [0.0, 1e-17, 1.1e-16, 2e-16, 1e-15, 1e-12])
def test_feet_of_points_near_the_long_axis_of_an_ellipse(y: float) -> None:
    for x in (0.0, 0.1, 1.0, 2.9, 3.1):
        for angle in ellipse_feet(x, y, 3.0, 1.0):
            foot = np.array([3.0 * np.cos(angle), np.sin(angle)])
            along = np.array([-3.0 * np.sin(angle), np.cos(angle)])
            assert abs((np.array([x, y]) - foot) @ along) < 1e-7


def test_a_line_does_not_grow_without_end_to_hold_its_direction() -> None:
    session = sketch("add_line -6,2.4 6.7,-6.4 9.6,-2.9; add_point 6.7,-6.4; lock P0")
    session.run("fillet L0 L1 1.2")
    try:
        session.run("coincident L0.p2 P0")
    except AraelError as error:
        assert error.diagnostics[0].code in ("E1231", "E1233", "E1234", "E1220")
    assert np.abs(session.document.values).max() < 1e4


def test_a_refused_length_does_not_let_a_drag_jump_to_a_knot() -> None:
    """The nearest that the point comes to the line's other end is a knot of the spline."""
    session = sketch("add_spline 0,0 2,6 6,-4 10,6 14,0")
    for pole in range(1, 6):
        session.run(f"lock S0.pole{pole}")
    session.run("add_line 9,2 6,-9; lock L0.p2; point_on L0.p1 S0; length L0 12")
    # A solution on another piece of the spline is not excluded.
    assert refused(session, "length L0 9.99") == "E1234"
    session.run("delete d0")
    before = session.document.values.copy()
    session.run("drag L0.p1 @0.01,0")
    assert 0 < np.abs(session.document.values - before).max() < 0.02
    session.editor.layout.check()


def test_a_point_on_a_knot_of_a_spline_is_on_either_piece() -> None:
    session = sketch("add_spline 0,0 1,2 3,2 4,0 6,-1; add_point 2,1.5; point_on P0 S0")
    at = session.document.point_at("P0")
    session.editor.drag({"P0": (5.9, -0.9)})
    for k in range(60):
        session.editor.drag({"P0": (5.9 - 0.1 * k, 0.5)})
        session.editor.layout.check()
        assert np.isfinite(session.document.values[at])


def test_a_move_leaves_something_of_the_line_between_what_is_moved_and_what_is_not() -> None:
    session = sketch("add_line 0,0 4,0 4,3; lock L0.p1")
    assert refused(session, "move L1 from L0.p2 to L0.p1") == "E1220"


def test_geometry_without_extent_is_a_message_in_every_command() -> None:
    session = sketch("add_line 0,0 4,0; add_line 1,1 2,3")
    at = session.document.point_at("L0.p2")
    with session.document.transaction("collapse"):
        session.document.set_values([at], [0.0])
    assert refused(session, "measure L0 L1") == "E1220"


@pytest.mark.parametrize(
    "line",
    ["tangent L0.p1 L0.p2", "midpoint L0.p1 L0", "point_on A0.center A0", "distance L0.p1 L0 3"],
)
def test_a_curve_is_not_related_to_its_own_points(line: str) -> None:
    assert refused(sketch("add_line 0,0 4,0; add_circle 9,9 1"), line) == "E1222"


def test_a_point_of_a_spline_may_lie_on_it() -> None:
    session = sketch("add_spline 0,0 1,2 3,2 4,0 6,-1; point_on S0.pole3 S0")
    assert session.editor.solve().solved


@pytest.mark.parametrize("size", [1e-5, 1e-3, 1.0, 1e3, 1e5])
def test_freedoms_of_an_ellipse_do_not_depend_on_its_size(size: float) -> None:
    session = sketch(f"add_ellipse 0,0 {3 * size} {size} 20; lock EA0.center")
    assert session.editor.judge.freedoms().by_entity["EA0"] == 3
    session.run(f"radius EA0 {3 * size}; radius_b EA0 {size}")
    assert session.editor.judge.freedoms().by_entity["EA0"] == 1


def test_a_range_goes_on_after_the_last_ellipse_is_deleted() -> None:
    session = sketch("add_line 0,0 4,0; add_ellipse 9,9 3 1 20; length L0 >= 3")
    session.run("radius EA0 2; delete EA0; length L0 >= 6")
    assert session.document.numbers_of("L0")[2] - session.document.numbers_of("L0")[0] > 5.9


@pytest.mark.parametrize(
    ("script", "line", "reason"),
    [
        ("add_ellipse 0,0 3 1 0", "total_length EA0 12", "can be measured (`derived`), not set"),
        (
            "add_line 0,0 5,0; add_arc 5,0 9,4 8,1",
            "smooth L0.p2 A0.start",
            "a line has no curvature",
        ),
    ],
)
def test_what_cannot_be_by_itself_is_refused_with_the_reason(
    script: str, line: str, reason: str
) -> None:
    session = sketch(script)
    with pytest.raises(AraelError, match=re.escape(reason)) as caught:
        session.run(line)
    assert caught.value.diagnostics[0].code == "E1231"
