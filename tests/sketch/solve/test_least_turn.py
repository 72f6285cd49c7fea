"""A new length does not turn what nothing asks to turn."""

from __future__ import annotations

import math

import pytest

from arael.sketch import Sketch


def directions(sketch: Sketch) -> list[float]:
    found = []
    for one in sketch.document.entities.values():
        if one.kind == "line":
            a, b, c, d = sketch.document.numbers_of(one.name).tolist()
            found.append(math.degrees(math.atan2(d - b, c - a)))
    return found


def places(sketch: Sketch, name: str) -> list[float]:
    return [float(x) for x in sketch.document.numbers_of(name)]


@pytest.mark.parametrize("held", ["", "lock L0.p1", "lock L2.p1"])
@pytest.mark.parametrize("turn", [0.0, 33.0])
@pytest.mark.parametrize("rest", [0, 80])
def test_a_rectangle_without_directions_does_not_turn(held: str, turn: float, rest: int) -> None:
    sketch = Sketch()
    sketch.run("add_rect 0,0 5,3")
    sketch.run("length L0 5; length L1 3")
    sketch.run(f"rotate L0 L1 L2 L3 about 2,1 {turn}")
    for k in range(rest):  # solved as a part then
        sketch.run(f"add_rect {20 * k + 30},30 {20 * k + 35},33 hv")
    if held:
        sketch.run(held)
    before = directions(sketch)
    for length in (5.5, 8.0, 2.0):
        sketch.run(f"length L0 {length}")
        assert directions(sketch)[:4] == pytest.approx(before[:4], abs=1e-8)
    assert not sketch.editor.solver.left_open()


def test_what_is_held_at_two_points_turns_as_it_has_to() -> None:
    sketch = Sketch()
    sketch.run("add_line 0,0 4,0 4,3; lock L0.p1; lock L1.p2; length L0 4; length L1 3")
    sketch.run("length L0 4.5")
    assert places(sketch, "L0")[:2] + places(sketch, "L1")[2:] == [0, 0, 4, 3]
    assert math.dist(places(sketch, "L0")[:2], places(sketch, "L0")[2:]) == pytest.approx(4.5)


def test_a_line_that_others_only_touch_keeps_its_direction() -> None:
    sketch = Sketch()
    sketch.run("add_line 0,0 10,0 14,7 3,9 0,0; length L0 10; length L0 12")
    assert places(sketch, "L0") == pytest.approx([-1, 0, 11, 0])
    assert places(sketch, "L2") == [14, 7, 3, 9]
