"""A drag's result does not depend on how fast the cursor moves."""

from __future__ import annotations

import math

import pytest

from arael.sketch import Sketch

# Grashof: 20 + 70 < 50 + 60, so its two assemblies are not connected.
CRANK_ROCKER = """ground = add_line 0,0 70,0 constr
lock ground.p1 0,0; lock ground.p2 70,0
crank = add_line 0,0 12,16
coupler = add_line crank.p2 60,45
rocker = add_line coupler.p2 ground.p2
length crank 20; length coupler 60; length rocker 50"""
#: Where crank and coupler are in line, 40 long from the origin: the end of the rocker's swing.
END = (40 * 5 / 7, 40 * math.sqrt(24) / 7)


def linkage() -> Sketch:
    sketch = Sketch()
    sketch.run(CRANK_ROCKER)
    return sketch


@pytest.mark.parametrize("frames", [1, 2, 3, 7, 40, 200])
def test_a_rocker_stops_at_the_end_of_its_swing(frames: int) -> None:
    sketch = linkage()
    x, y = sketch["coupler.p2"]
    with sketch.dragging("rocker.p1") as drag:
        for k in range(1, frames + 1):
            share = k / frames
            drag.to((x + (60 - x) * share, y + (-45 - y) * share))
    assert tuple(sketch["coupler.p2"]) == pytest.approx(END, abs=1e-6)


def test_a_rocker_stops_there_by_the_command_too() -> None:
    sketch = linkage()
    sketch.run("drag rocker.p1 60,-45")
    assert tuple(sketch["coupler.p2"]) == pytest.approx(END, abs=1e-6)


@pytest.mark.parametrize("frames", [8, 60])
def test_a_crank_turns_in_few_frames(frames: int) -> None:
    sketch = linkage()
    before, start = tuple(sketch["coupler.p2"]), math.atan2(*reversed(tuple(sketch["crank.p2"])))
    with sketch.dragging("crank.p2") as drag:
        for k in range(1, frames + 1):
            angle = start + 2 * math.pi * k / frames
            drag.to((20 * math.cos(angle), 20 * math.sin(angle)))
    assert tuple(sketch["coupler.p2"]) == pytest.approx(before, abs=1e-6)


def test_a_frame_by_the_clock_goes_on_along_the_way() -> None:
    sketch = linkage()
    with sketch.dragging("rocker.p1") as drag:
        for _ in range(2000):
            if drag.to((60.0, -45.0), seconds=1e-9).converged:
                break
    assert tuple(sketch["coupler.p2"]) == pytest.approx(END, abs=1e-3)


def test_a_chain_passes_where_it_is_straight() -> None:
    sketch = Sketch()
    sketch.run(
        """a = add_line 0,0 6,8; b = add_line a.p2 12,0
        lock a.p1; length a 10; length b 10; drag b.p2 0,12"""
    )
    assert tuple(sketch["b.p2"]) == pytest.approx((0.0, 12.0), abs=1e-7)
