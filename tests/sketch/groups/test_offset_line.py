"""`offset_line`: a parallel line at its distance, without freedom of its own."""

from __future__ import annotations

import pytest

from tests.sketch.groups.support import at, code, freedom, sketch


@pytest.mark.parametrize(("words", "y"), [("2", 2), ("2 right", -2), ("-2", -2), ("2 left", 2)])
def test_sides_of_an_offset_line(words: str, y: float) -> None:
    s = sketch("add_line 0,0 5,0")
    before = freedom(s)
    s.run(f"offset_line L0 {words}")
    assert freedom(s) == before
    assert at(s, "L1.p1") == pytest.approx((0, y))


def test_an_offset_line_follows_a_parameter_and_its_source() -> None:
    s = sketch("param w 2\nadd_line 0,0 5,0\nlock L0.p1; horizontal L0\noffset_line L0 w/2")
    s.run("param w 6; length L0 9")
    assert at(s, "L1.p2") == pytest.approx((9, 3))


def test_without_pins_the_ends_slide() -> None:
    s = sketch("add_line 0,0 5,0")
    before = freedom(s)
    s.run("offset_line L0 2 nopin")
    assert freedom(s) == before + 2


def test_no_distance_is_refused() -> None:
    s = sketch("add_line 0,0 5,0")
    assert code(s, "offset_line L0 0") == "E1257"
    assert list(s.document.entities) == ["L0"]
