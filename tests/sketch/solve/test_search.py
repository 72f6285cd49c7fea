"""Solutions that steps of least norm do not find: with all sides kept, and from singular starts."""

from __future__ import annotations

import math

import pytest

from arael.diagnostics.records import AraelError
from arael.sketch import Sketch


def test_a_step_shorter_than_the_change_of_a_length_keeps_its_length() -> None:
    sketch = Sketch()
    sketch.run(
        """add_line 0,0 50,0 50,8 48,8 48,40 0,40 0,0
        horizontal L0; vertical L1; horizontal L2; vertical L3; horizontal L4; vertical L5
        lock L0.p1 0,0; length L0 50; length L0 45"""
    )
    assert math.dist(sketch["L2.p1"], sketch["L2.p2"]) == pytest.approx(2.0, abs=1e-9)
    assert tuple(sketch["L2.p2"]) == pytest.approx((43.0, 8.0), abs=1e-9)
    assert tuple(sketch["L4.p2"]) == pytest.approx((0.0, 40.0), abs=1e-9)


def test_a_step_shorter_than_the_change_of_a_parameter_keeps_its_length() -> None:
    sketch = Sketch()
    sketch.run(
        """param h 22
        add_line 0,0 0,20 12,20 12,22 40,22
        vertical L0; horizontal L1; vertical L2; horizontal L3
        lock L0.p1 0,0; vdistance L0.p1 L3.p2 h; param h 17"""
    )
    assert tuple(sketch["L2.p1"]) == pytest.approx((12.0, 15.0), abs=1e-9)
    assert tuple(sketch["L2.p2"]) == pytest.approx((12.0, 17.0), abs=1e-9)


@pytest.mark.parametrize("change", [0.6, 3.0, 40.0])
def test_a_line_behind_one_that_grows_stays_ahead_of_it(change: float) -> None:
    sketch = Sketch()
    sketch.run(
        f"""a = add_line 0,0 10,0; b = add_line 10,0 10.5,0
        horizontal a; horizontal b; lock a.p1; length a 10; length a {10 + change}"""
    )
    assert tuple(sketch["b.p1"]) == pytest.approx((10 + change, 0.0))
    assert tuple(sketch["b.p2"]) == pytest.approx((10.5 + change, 0.0))


BARS = "a = add_line 0,0 10,0; b = add_line 10,0 20,0; length a 10; length b 10; lock a.p1\n"
CIRCLE = "c = add_circle 0,0 10 noconnect; lock c.center; radius c 10\n"
CRANK = """crank = add_line 0,0 10,0; rod = add_line 10,0 40,0; lock crank.p1
length crank 10; length rod 30; horizontal crank.p1 rod.p2
"""


@pytest.mark.parametrize("kind", ["distance", "hdistance"])
def test_straight_bars_fold(kind: str) -> None:
    sketch = Sketch()
    sketch.run(f"{BARS}{kind} a.p1 b.p2 15")
    joint, end = sketch["a.p2"], sketch["b.p2"]
    assert math.dist((0, 0), joint) == pytest.approx(10.0)
    assert math.dist(joint, end) == pytest.approx(10.0)
    reach = math.hypot(*end) if kind == "distance" else end[0]
    assert reach == pytest.approx(15.0)


@pytest.mark.parametrize("at", ["10,0", "-10,0"])
def test_a_point_leaves_the_side_of_a_circle_for_its_top(at: str) -> None:
    sketch = Sketch()
    replies = sketch.run(f"{CIRCLE}p = add_point {at} noconnect; point_on p c; vertical p c.center")
    x, y = sketch.run("print p")[0].data["values"][0]
    assert (x, abs(y)) == pytest.approx((0.0, 10.0), abs=1e-9)
    # It takes its degree of freedom where it has come to.
    assert "no degree of freedom" not in "\n".join(reply.text for reply in replies)
    assert sketch.run("dof")[0].data["freedoms"] == 0


def test_the_end_of_a_line_leaves_the_side_of_a_circle() -> None:
    sketch = Sketch()
    sketch.run(f"{CIRCLE}l = add_line 10,0 0,30 noconnect; lock l.p2; point_on l.p1 c; vertical l")
    assert tuple(sketch["l.p1"]) == pytest.approx((0.0, 10.0), abs=1e-9)


def test_a_slider_crank_leaves_its_dead_point() -> None:
    sketch = Sketch()
    sketch.run(f"{CRANK}hdistance crank.p1 rod.p2 35")
    x = (10**2 + 35**2 - 30**2) / 70  # of the triangle 10, 30, 35
    assert tuple(sketch["crank.p2"]) == pytest.approx((x, math.sqrt(100 - x * x)), abs=1e-8)


def test_the_same_mirror_image_is_taken_each_time() -> None:
    ends = set()
    for _ in range(3):
        sketch = Sketch()
        sketch.run(f"{CRANK}hdistance crank.p1 rod.p2 35")
        ends.add(tuple(sketch["crank.p2"]))
    assert len(ends) == 1


@pytest.mark.parametrize(
    "text",
    [
        f"{BARS}distance a.p1 b.p2 25",
        f"{CIRCLE}p = add_point 10,0 noconnect; point_on p c; hdistance p c.center 11",
        f"{CRANK}hdistance crank.p1 rod.p2 41",
    ],
)
def test_what_is_out_of_reach_is_impossible(text: str) -> None:
    sketch = Sketch()
    with pytest.raises(AraelError) as caught:
        sketch.run(text)
    assert "E1231" in str(caught.value)


def test_a_range_of_a_free_arc_is_reached_past_half_a_turn() -> None:
    sketch = Sketch()
    sketch.run("a = add_arc 0,0 3,3 -3,3; sweep a 30 to 90")  # is 270
    assert 30.0 <= sketch.editor.measure("sweep", ["A0"]) <= 90.0 + 1e-6
    sketch.run("sweep a 45")
    assert sketch.editor.measure("sweep", ["A0"]) == pytest.approx(45.0)


#: A script, and what the least step would fulfil by shrinking a line to nothing.
KEPT = [
    ("add_line -2.6,5.7 -6.3,7.7; add_line 0,-1.4 6,9.7; perpendicular L1 L0; length L1 driven",
     "horizontal L0.p1 L0.p2"),
    ("add_line 1.9,-2.2 2.5,3.1 -9.7,5.5; add_line 9.9,0.2 -7.8,7.9; distance L2 L1 driven",
     "parallel L0 L1"),
    ("add_line -0.8,8.7 8.9,-8.1 -10,-0.9; add_line 8.2,6.2 8.1,6.3; lock L2.p1;"
     "vdistance L0.p2 L2.p2 driven; hdistance L0.p1 L1.p2 driven; angle L2 L0 driven;"
     "xangle L2 148", "xangle L2 131"),
]  # fmt: skip


@pytest.mark.parametrize(("script", "line"), KEPT)
def test_what_a_collapse_would_fulfil_is_fulfilled_otherwise(script: str, line: str) -> None:
    sketch = Sketch()
    sketch.run(script)
    sketch.run(line)
    assert not sketch.editor.solver.left_open()
    lines = [one.name for one in sketch.document.entities.values() if one.kind == "line"]
    ends = [sketch.document.numbers_of(name) for name in lines]
    assert min(math.dist(one[:2], one[2:]) for one in ends) > 0.05


def test_what_was_searched_for_holds_up_to_rounding() -> None:
    sketch = Sketch()
    sketch.run("add_line 1.6,-7.8 -1.2,-7 4.6,-9.7; horizontal L1; perpendicular L0 L1")
    sketch.run("add_circle 9,9 1 noconnect")
    with pytest.raises(AraelError) as caught:  # the rank of these two is one
        sketch.run("angle L0 L1 90")
    assert caught.value.diagnostics[0].code == "E1230"


def test_where_a_whole_step_cannot_keep_all_sides_a_part_of_it_is_made() -> None:
    """Rectangles without directions are joined to a chain, each farther from its end."""
    sketch = Sketch()
    for k in range(9):
        sketch.run(f"add_rect {6 * k},0 {6 * k + 5},3")
        if k:
            sketch.run(f"coincident L{4 * k}.p1 L{4 * k - 4}.p2")
        sketch.run(f"length L{4 * k} 5; length L{4 * k + 1} 3")
    assert not sketch.editor.solver.left_open()
