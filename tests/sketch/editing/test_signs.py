"""Signs of values say on which side; sides that alone are in the way are named."""

from __future__ import annotations

import math

import pytest

from arael.diagnostics.records import AraelError
from arael.sketch import Sketch

LEVEL = "add_line 0,0 10,0 noconnect; fix L0"


def refused(sketch: Sketch, line: str) -> tuple[str, str]:
    with pytest.raises(AraelError) as caught:
        sketch.run(line)
    found = caught.value.diagnostics[0]
    return found.code, found.message


@pytest.mark.parametrize("y", [2.0, -2.0])
def test_a_negative_distance_of_a_point_is_to_the_right_of_the_line(y: float) -> None:
    sketch = Sketch()
    sketch.run(f"{LEVEL}; add_point 3,{y} noconnect")
    for line, found in (
        ("distance P0 L0 -5", -5),
        ("distance L0 P0 4", -4),  # a value without a sign keeps the side
        ("distance L0 P0 -3", -3),
        ("set_driven d0 -1", -1),
    ):
        sketch.run(line)
        assert sketch.document.numbers_of("P0").tolist() == pytest.approx([3, found])


@pytest.mark.parametrize("ends", ["2,3 8,3", "8,3 2,3"])
def test_a_negative_distance_of_lines_is_by_the_direction_of_the_first(ends: str) -> None:
    sketch = Sketch()
    sketch.run(f"{LEVEL}; add_line {ends} noconnect")
    along = 1 if ends.startswith("2") else -1
    for line, found in (
        ("distance L0 L1 -5", -5),
        ("distance L0 L1 4", -4),
        # L0 is to be on the right of L1: below it if that runs along x.
        ("distance L1 L0 -3", 3 * along),
        ("distance L0 L1 -2", -2),
    ):
        sketch.run(line)
        assert sketch.document.numbers_of("L1")[[1, 3]].tolist() == pytest.approx([found, found])


def test_a_negative_distance_from_a_circle_is_inside() -> None:
    sketch = Sketch()
    sketch.run("add_circle 0,0 5 noconnect; fix A0; add_point 8,0 noconnect; distance P0 A0 -1")
    assert math.hypot(*sketch.document.numbers_of("P0")) == pytest.approx(4)


def test_a_negative_gap_around_one_center_makes_the_second_circle_the_smaller() -> None:
    sketch = Sketch()
    sketch.run("add_circle 0,0 5 noconnect; fix A0; add_circle 0,0 8; distance A0 A1 -2")
    assert sketch.document.numbers_of("A1")[2] == pytest.approx(3)
    sketch.run("distance A1 A0 -1")
    assert sketch.document.numbers_of("A1")[2] == pytest.approx(6)


def test_a_range_of_negative_numbers_is_on_the_other_side() -> None:
    sketch = Sketch()
    sketch.run("add_point 0,0; lock P0; add_point 9,1 noconnect")
    for line, found in (
        ("hdistance P0 P1 -5 to -2", -2),
        ("hdistance P0 P1 <= -3", -3),
        ("hdistance P1 P0 -7 to -6", 6),
    ):
        sketch.run(line)
        assert sketch.document.numbers_of("P1")[0] == pytest.approx(found)


@pytest.mark.parametrize("value", ["-2 to 5", ">= -2"])
def test_a_range_from_one_side_to_the_other_is_refused(value: str) -> None:
    sketch = Sketch()
    sketch.run(f"{LEVEL}; add_point 9,1 noconnect; add_line 0,0 5,5 noconnect")
    for what in ("hdistance L0.p1 P0", "distance P0 L0", "angle L0 L1"):
        code, message = refused(sketch, f"{what} {value}")
        assert code == "E1220"
        assert f"one side of 0, found {value}" in message
    assert not sketch.document.dimensions


def test_distances_without_sides_have_no_sign() -> None:
    sketch = Sketch()
    sketch.run("add_point 0,0; add_point 9,1; add_circle 20,0 2; add_circle 40,0 3")
    code, message = refused(sketch, "distance P0 P1 -2")
    assert (code, message) == ("E1220", "`distance` of points has no sign, found -2")
    code, message = refused(sketch, "distance A0 A1 -2 to 3")
    assert (code, message) == ("E1220", "`distance` of circles has no sign, found -2")


@pytest.mark.parametrize("before", ["", "angle L0 L1 20"])
@pytest.mark.parametrize("value", [120, 170, -170, -120])
def test_an_angle_whose_only_solution_is_half_a_turn_away_is_on_the_other_side(
    before: str, value: float
) -> None:
    sketch = Sketch()
    sketch.run(f"{LEVEL}; add_line 10,0 14,3; add_point 14,-9 noconnect; lock P0")
    sketch.run(f"vertical L1.p2 P0; {before}")  # all directions from -90 to 90 degrees
    code, message = refused(sketch, f"angle L0 L1 {value}")
    assert code == "E1233"
    assert f"`angle L0 L1 {value}`" in message
    assert "d0 would turn over" in message


def test_an_angle_that_only_infinity_would_have_is_on_no_side() -> None:
    sketch = Sketch()
    sketch.run(f"{LEVEL}; add_line 10,0 14,3; add_point 14,-9 noconnect; lock P0")
    sketch.run("vertical L1.p2 P0")
    assert refused(sketch, "perpendicular L0 L1")[0] in ("E1231", "E1234")
