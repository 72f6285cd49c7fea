"""Slots and polygons keep their shape."""

from __future__ import annotations

import pytest

from tests.sketch.groups.support import at, code, freedom, number, sketch


def test_a_slot_has_five_freedoms_and_stays_a_slot() -> None:
    s = sketch("add_slot 0,0 10,0 2")
    assert freedom(s) == 5
    s.run("radius A0 3")
    assert number(s, "A1.radius") == pytest.approx(3)
    assert number(s, "L0.length") == pytest.approx(number(s, "L1.length"))


@pytest.mark.parametrize("count", [3, 4, 6])
def test_a_polygon_has_four_freedoms_and_stays_regular(count: int) -> None:
    s = sketch(f"add_polygon {count} 0,0 5,0")
    assert freedom(s) == 4
    s.run("length L0 3")
    assert {round(number(s, f"L{i}.length"), 6) for i in range(count)} == {3.0}


def test_the_middle_of_a_flat_side() -> None:
    s = sketch("add_polygon 4 0,0 5,0 flat")
    assert at(s, "L0.p1") == pytest.approx((5, -5))


def test_shapes_without_extent_are_refused() -> None:
    s = sketch("")
    assert code(s, "add_polygon 5 0,0 0,0") == "E1220"
    assert code(s, "add_slot 1,1 1,1 2") == "E1220"
    assert code(s, "add_slot 1,1 2,1 0") == "E1257"
    assert not s.document.entities
