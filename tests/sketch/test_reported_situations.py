"""Situations that users of other sketchers reported as faults, rebuilt: none of them happens here.

Every test is one of them, in our own words.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.commands.session import Session


def sketch(script: str) -> Session:
    session = Session()
    session.run(script)
    return session


def number(session: Session, expression: str) -> float:
    return float(session.scope.value(expression))  # type: ignore[arg-type]


def at(session: Session, handle: str) -> tuple[float, float]:
    offset = session.document.point_at(handle)
    x, y = session.document.values[offset : offset + 2].tolist()
    return x, y


def code(session: Session, script: str) -> str:
    with pytest.raises(AraelError) as caught:
        session.run(script)
    return caught.value.diagnostics[0].code


TRIANGLE = """
a = add_line 0,0 5,0
b = add_line 5,0 3,4
c = add_line 3,4 0,0
lock a.p1 0,0
horizontal a
length a 5
length b 4.5
length c 5
"""

RECTANGLE = """
bottom, right, top, left = add_rect 0,0 5,3 hv
lock bottom.p1 0,0
length bottom 5
length right 3
"""


# --- flips ----------------------------------------------------------------------------------


@pytest.mark.parametrize("value", [5.5, 7, 9, 9.4, 6, 5.1])
def test_a_triangle_does_not_turn_over_when_a_side_changes(value: float) -> None:
    session = sketch(TRIANGLE)
    session.run(f"length c {value}")
    assert at(session, "L1.p2")[1] > 0.0
    assert number(session, "L2.length") == pytest.approx(value, abs=1e-9)


def test_a_dimension_that_becomes_large_and_small_again_gives_the_same_drawing() -> None:
    session = sketch(RECTANGLE)
    before = session.document.values.copy()
    for width in (5000.0, 0.001, 37.0, 5.0):
        session.run(f"length L0 {width}")
        assert at(session, "L0.p2") == pytest.approx((width, 0.0), abs=1e-9 * max(1.0, width))
    assert np.allclose(session.document.values, before, atol=1e-9)


def test_a_point_stays_on_its_side_of_a_line() -> None:
    session = sketch("add_line 0,0 10,0; lock L0.p1 0,0; horizontal L0; length L0 10")
    session.run("add_point 4,3; distance P0 L0 3; hdistance L0.p1 P0 4")
    for height in (0.5, 20, 0.01, 3):
        session.run(f"distance P0 L0 {height}")
        assert at(session, "P0") == pytest.approx((4.0, height), abs=1e-8)


def test_an_angle_stays_in_its_sector() -> None:
    session = sketch("add_line 0,0 10,0; lock L0.p1 0,0; horizontal L0; length L0 10")
    session.run("add_line 0,0 5,5; length L1 7; angle L0 L1 45")
    for angle in (10, 100, 170, 91, 89, 1, 45):
        session.run(f"angle L0 L1 {angle}")
        x, y = at(session, "L1.p2")
        assert math.degrees(math.atan2(y, x)) == pytest.approx(angle, abs=1e-7)


def test_a_tangent_circle_stays_outside_and_beside() -> None:
    session = sketch("add_line 0,0 10,0; lock L0.p1 0,0; horizontal L0; length L0 10")
    session.run("add_circle 5,2 2; tangent L0 A0; hdistance L0.p1 A0.center 5; radius A0 2")
    for radius in (0.1, 30, 2):
        session.run(f"radius A0 {radius}")
        assert at(session, "A0.center") == pytest.approx((5.0, radius), abs=1e-7)


def test_an_arc_does_not_turn_inside_out() -> None:
    session = sketch("add_arc 5,0 0,5 3.5355339,3.5355339; lock A0.center 0,0; radius A0 5")
    session.run("xangle_start = 0; sweep A0 90")
    for sweep in (10, 179, 181, 300, 350, 90):
        session.run(f"sweep A0 {sweep}")
        assert number(session, "A0.sweep") == pytest.approx(sweep, abs=1e-7)


# --- drags ----------------------------------------------------------------------------------


def test_a_dragged_chain_comes_back() -> None:
    lines = "\n".join(f"add_line {i},0 {i + 1},0; length L{i} 1" for i in range(30))
    session = sketch(lines + "\nlock L0.p1 0,0")
    session.editor.drag({"L29.p2": (15.0, 14.0)})  # somewhere, so that no link is straight
    before = session.document.values.copy()
    start = at(session, "L29.p2")
    with session.editor.dragging(["L29.p2"]) as drag:
        for t in [*np.linspace(0.0, 1.0, 25)[1:], *np.linspace(1.0, 0.0, 25)[1:]]:
            assert drag.to((start[0] - 8 * t, start[1] + 9 * t)).solved
    assert np.abs(session.document.values - before).max() <= 1e-9


def test_a_fully_defined_sketch_does_not_move_when_dragged() -> None:
    session = sketch(RECTANGLE)
    before = session.document.values.tobytes()
    session.editor.drag({"L1.p2": (100.0, 100.0)})
    assert session.document.values.tobytes() == before


def test_a_satisfied_sketch_does_not_creep() -> None:
    session = sketch(TRIANGLE)
    before = session.document.values.tobytes()
    for _ in range(20):
        session.editor.solve()
    assert session.document.values.tobytes() == before


# --- redundant, impossible ------------------------------------------------------------------


def test_symmetric_drawings_are_not_called_redundant() -> None:
    session = sketch(
        """
        axis = add_line 0,-5 0,5
        lock axis.p1 0,-5; lock axis.p2 0,5
        add_point -3,1; add_point 3,1
        symmetry P0 axis P1
        add_line P0 P1
        """
    )
    session.run("length L1 6")
    session.run("vdistance axis.p1 P0 6")
    assert session.editor.judge.freedoms().total == 0


def test_a_square_drawn_square_takes_every_constraint() -> None:
    session = sketch("a, b, c, d = add_line 0,0 4,0 4,4 0,4 0,0")
    session.run("perpendicular a b; perpendicular b c; perpendicular c d; equal a b")
    assert session.editor.judge.freedoms().total == 4
    session.run("length a 4; lock a.p1 0,0; horizontal a")
    assert session.editor.judge.freedoms().total == 0


def test_redundant_and_impossible_are_told_apart() -> None:
    session = sketch(RECTANGLE)
    assert code(session, "length L2 5") == "E1230"
    assert code(session, "length L2 6") == "E1231"


def test_the_culprits_are_named_and_dropping_any_one_makes_room() -> None:
    session = sketch(RECTANGLE)
    with pytest.raises(AraelError) as caught:
        session.run("length L2 6")
    text = str(caught.value)
    members = [name for name in (*session.document.constraints, "d0", "d1") if f"`{name}`" in text]
    assert "d0" in members
    assert "d1" not in members
    for name in members:
        other = sketch(RECTANGLE)
        other.run(f"delete {name}")
        other.run("length L2 6")


@pytest.mark.parametrize("value", [99, 0.01])
@pytest.mark.parametrize("corners", ["L1 L2 1", "L2 L3 1", "L1 L2 1; fillet L2 L3 1"])
def test_culprits_of_a_length_beside_a_fillet_are_named(corners: str, value: float) -> None:
    session = sketch("add_rect 0,0 10,6 hv; length L1 6; length L0 10")
    session.run(f"fillet {corners}")
    with pytest.raises(AraelError) as caught:
        session.run(f"length L2 {value}")
    assert caught.value.diagnostics[0].code == "E1231"
    assert "is impossible together with `" in str(caught.value)


def test_an_impossible_triangle_names_its_sides() -> None:
    session = sketch("a, b, c = add_line 0,0 1,0 0.5,1 0,0")
    session.run("length a 1; length b 1")
    before = session.document.values.tobytes()
    with pytest.raises(AraelError) as caught:
        session.run("length c 3")
    assert caught.value.diagnostics[0].code == "E1231"
    assert "`d0`" in str(caught.value)
    assert "`d1`" in str(caught.value)
    assert session.document.values.tobytes() == before
    assert list(session.document.dimensions) == ["d0", "d1"]


def test_harmless_redundancy_can_stay() -> None:
    session = sketch(RECTANGLE)
    session.run("length L2 5 force")
    session.run("length L0 5")
    assert session.editor.judge.freedoms().total == 0
    assert len(session.editor.judge.freedoms().redundant) == 1


def test_free_parts_can_be_found() -> None:
    session = sketch(RECTANGLE)
    session.run("add_circle 1,1 0.5; radius A0 0.5; hdistance L0.p1 A0.center 1")
    freedoms = session.editor.judge.freedoms()
    assert freedoms.total == 1
    assert freedoms.by_entity["A0"] == 1
    assert freedoms.by_entity["L0"] == 0
    assert [m.sentence for m in session.editor.judge.free()] == ["A0 can move along y"]


# --- collapse, scale ------------------------------------------------------------------------


def test_a_line_does_not_collapse_to_a_point() -> None:
    session = sketch(
        "add_line 0,0 5,0; add_line 5,0 5,3; lock L0.p1 0,0; horizontal L0; length L0 5"
    )
    session.run("vertical L1")
    assert code(session, "length L1 0") == "E1220"
    with pytest.raises(AraelError):
        session.run("coincident L1.p1 L1.p2")
    assert number(session, "L1.length") > 1.0


@pytest.mark.parametrize(
    ("scale", "shift"), [(1e-6, 0.0), (1.0, 0.0), (1e6, 0.0), (1.0, 1e6), (1e6, 1e6)]
)
def test_the_first_dimension_does_not_distort_the_drawing(scale: float, shift: float) -> None:
    x = [shift + scale * v for v in (0.0, 5.0, 3.0)]
    y = [shift + scale * v for v in (0.0, 0.0, 4.0)]
    session = sketch(
        "a, b, c = add_line " + " ".join(f"{x[i]!r},{y[i]!r}" for i in (0, 1, 2, 0))
        if scale >= 1e-2
        else f"a = add_line {x[0]!r},{y[0]!r} {x[1]!r},{y[1]!r} noconnect"
    )
    session.run(f"length a {10 * scale!r}")
    assert number(session, "L0.length") == pytest.approx(10 * scale, rel=1e-9)
    assert np.abs(session.document.values - shift).max() < 20 * scale


# --- automatic constraints ------------------------------------------------------------------


def test_automatic_constraints_are_told_and_can_be_switched_off() -> None:
    session = Session()
    first, second = session.run("add_line 0,0 5,0\nadd_line 5,0 5,3")
    assert first.text.startswith("Added L0:")
    assert "[connected: L1.p1=L0.p2 (C0)]" in second.text
    session.run("add_line 5,3 0,3 noconnect")
    assert len(session.document.constraints) == 1


# --- deleting, undo -------------------------------------------------------------------------


def test_deleting_takes_what_rests_on_it_in_one_step() -> None:
    session = sketch(RECTANGLE)
    before = session.document.values.tobytes(), dict(session.document.constraints)
    session.run("delete L1")
    assert not any(
        "L1" in c.args or "L1.p1" in c.args for c in session.document.constraints.values()
    )
    session.run("undo")
    assert (session.document.values.tobytes(), dict(session.document.constraints)) == before


# --- drags that turn something over, cuts, size, no word why -------------------------------------


def test_a_drag_across_does_not_turn_a_triangle_over() -> None:
    session = sketch(TRIANGLE)
    session.run("delete d2")  # side c is free: the corner runs on a circle about the end of a
    with session.editor.dragging(["L1.p2"]) as drag:
        last = x, y = at(session, "L1.p2")
        for t in np.linspace(0.0, 1.0, 40):
            drag.to((x + 4.0 * t, y - 3.0 * t))
            now = at(session, "L1.p2")
            assert math.dist(now, last) < 0.5
            assert math.dist(now, (5.0, 0.0)) == pytest.approx(4.5, abs=1e-8)
            assert now[1] > 0.0
            last = now


def test_a_fast_drag_of_a_tangent_circle_stays_on_its_side() -> None:
    session = sketch("add_line 0,0 10,0; lock L0.p1 0,0; horizontal L0; length L0 10")
    session.run("add_circle 5,2 2; tangent L0 A0; radius A0 2")
    for target in ((50.0, -40.0), (-9.0, 3.0), (5.0, -2.0), (5.0, 300.0)):
        session.editor.drag({"A0.center": target})
        assert at(session, "A0.center") == pytest.approx((target[0], 2.0), abs=1e-7)


def test_a_split_keeps_what_the_line_was_held_by() -> None:
    session = sketch(RECTANGLE + "add_line 2,-1 2,4; vertical L4; hdistance L0.p1 L4.p1 2")
    before = session.editor.judge.freedoms().total
    (reply,) = session.run("split bottom by L4")
    assert session.editor.judge.freedoms().total == before
    assert len(reply.names) == 2
    # the width still follows its dimension
    dimension = next(d for d in session.document.dimensions.values() if d.value.number == 5)  # type: ignore[union-attr]
    session.run(f"set_driven {dimension.name} 8")
    assert at(session, "L1.p1") == pytest.approx((8.0, 0.0), abs=1e-9)


def test_a_trim_keeps_what_the_rest_was_held_by() -> None:
    session = sketch("add_line 0,0 10,0; lock L0.p1 0,0; horizontal L0; add_line 6,-2 6,3")
    session.run("vertical L1; hdistance L0.p1 L1.p1 6; trim L0 by L1 forward")
    session.run("set_driven d0 7")
    (line,) = (name for name in session.document.entities if name.startswith("L") and name != "L1")
    assert at(session, f"{line}.p2") == pytest.approx((7.0, 0.0), abs=1e-9)
    kept = [one.kind for one in session.document.constraints.values() if line in one.args]
    assert "horizontal" in kept


def test_of_hundreds_of_parts_only_the_one_that_changed_is_moved() -> None:
    lines = [
        f"add_rect {6 * k},0 {6 * k + 5},3 hv\nlock L{4 * k}.p1\nlength L{4 * k} 5\n"
        f"length L{4 * k + 1} 3"
        for k in range(60)
    ]
    session = sketch("\n".join(lines))
    before = session.document.values.copy()
    session.run("length L120 4")
    moved = np.flatnonzero(session.document.values != before)
    own = [session.document.entities[f"L{k}"] for k in range(120, 124)]
    assert set(moved) <= {at for one in own for at in range(one.at, one.at + one.size)}
    assert len(moved)


@pytest.mark.parametrize("far", [3.0, 30.0, 300.0])
def test_a_sketch_that_is_drawn_badly_is_solved_all_the_same(far: float) -> None:
    # Six equal chords of a circle, from corners anywhere.
    angles = [0.0, 0.4, 0.9, 2.6, 3.0, 5.5]
    places = [(far * math.cos(a), 0.3 * far * math.sin(a)) for a in angles]
    text = " ".join(f"{x!r},{y!r}" for x, y in [*places, places[0]])
    session = sketch(f"add_line {text}; add_circle 0,0 {far}; lock A0.center 0,0; radius A0 2")
    for k in range(6):
        session.run(f"point_on L{k}.p1 A0")
    session.run("equal L0 L1 L2 L3 L4 L5")
    chord = number(session, "L0.length")
    assert 0.1 < chord <= 4.0
    for k in range(6):
        assert number(session, f"L{k}.length") == pytest.approx(chord, abs=1e-8)
        assert math.hypot(*at(session, f"L{k}.p1")) == pytest.approx(2.0, abs=1e-8)


def test_what_has_no_solution_from_here_is_named() -> None:
    session = sketch("add_line 0,0 4,0; lock L0.p1; lock L0.p2; add_line 4,0 4,3; length L1 3")
    with pytest.raises(AraelError) as caught:
        session.run("distance L0.p1 L1.p2 9")
    assert "`distance L0.p1 L1.p2 9` is impossible together with" in str(caught.value)
    assert "`d0`" in str(caught.value)


#: Complaints about other sketchers, each with a test here that could fail.
COMPLAINTS = {
    "flips when a dimension changes": [
        test_a_triangle_does_not_turn_over_when_a_side_changes,
        test_a_dimension_that_becomes_large_and_small_again_gives_the_same_drawing,
        test_a_point_stays_on_its_side_of_a_line,
        test_an_angle_stays_in_its_sector,
    ],
    "flips and jumps while dragging": [
        test_a_drag_across_does_not_turn_a_triangle_over,
        test_a_fast_drag_of_a_tangent_circle_stays_on_its_side,
        test_a_dragged_chain_comes_back,
        test_a_fully_defined_sketch_does_not_move_when_dragged,
    ],
    "redundant although it is not": [
        test_symmetric_drawings_are_not_called_redundant,
        test_a_square_drawn_square_takes_every_constraint,
    ],
    "harmless redundancy treated as failure": [test_harmless_redundancy_can_stay],
    "a useless or empty list of culprits": [
        test_the_culprits_are_named_and_dropping_any_one_makes_room,
        test_an_impossible_triangle_names_its_sides,
        test_culprits_of_a_length_beside_a_fillet_are_named,
    ],
    "redundant and impossible not told apart": [test_redundant_and_impossible_are_told_apart],
    "slow from hundreds of constraints on": [
        test_of_hundreds_of_parts_only_the_one_that_changed_is_moved
    ],
    "wrong count of freedoms, free parts that cannot be found": [test_free_parts_can_be_found],
    "tangents and arcs that turn inside out": [
        test_a_tangent_circle_stays_outside_and_beside,
        test_an_arc_does_not_turn_inside_out,
    ],
    "collapse to zero length accepted": [test_a_line_does_not_collapse_to_a_point],
    "trim and split that lose constraints": [
        test_a_split_keeps_what_the_line_was_held_by,
        test_a_trim_keeps_what_the_rest_was_held_by,
    ],
    "no convergence on solvable sketches and no word why": [
        test_a_sketch_that_is_drawn_badly_is_solved_all_the_same,
        test_what_has_no_solution_from_here_is_named,
    ],
    "a satisfied sketch that creeps": [test_a_satisfied_sketch_does_not_creep],
    "scale and the first dimension that distorts everything": [
        test_the_first_dimension_does_not_distort_the_drawing
    ],
    "unwanted automatic constraints": [test_automatic_constraints_are_told_and_can_be_switched_off],
    "deleting in several steps of undo": [test_deleting_takes_what_rests_on_it_in_one_step],
}


def test_every_test_of_this_file_answers_a_complaint() -> None:
    answered = [test.__name__ for tests in COMPLAINTS.values() for test in tests]
    here = [name for name in globals() if name.startswith("test_") and name not in answered]
    assert here == ["test_every_test_of_this_file_answers_a_complaint"]
    assert len(answered) == len(set(answered))
