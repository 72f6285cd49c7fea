"""`mirror`: copies that follow, without freedom of their own."""

from __future__ import annotations

import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.commands.session import Session
from tests.sketch.groups.support import at, code, freedom, number, sketch


def test_a_mirrored_line_follows_its_source() -> None:
    s = sketch("add_line 4,0 4,5\nadd_line 0,0 3,1")
    before = freedom(s)
    s.run("mirror L1 about L0")
    assert freedom(s) == before
    s.run("lock L0.p1; lock L0.p2; drag L1.p1 1,2")
    x, y = at(s, "L1.p1")
    assert at(s, "L2.p1") == pytest.approx((8 - x, y))


def test_a_mirrored_chain_is_connected_and_has_no_freedom_of_its_own() -> None:
    s = sketch("add_line 9,0 9,5\nadd_line 0,0 3,0 3,3\nadd_arc 3,3 0,3 1.5,4.5\nadd_circle 0,0 1")
    before = freedom(s)
    s.run("mirror L1 L2 A0 A1 about L0 strict")
    assert freedom(s) == before
    assert at(s, "A2.start") == pytest.approx(at(s, "L4.p2"))


@pytest.mark.parametrize("word", ["", "noconstraint", "strict"])
def test_words_of_mirror(word: str) -> None:
    s = sketch("add_line 4,0 4,5\nadd_line 0,0 3,1")
    n = len(s.document.constraints)
    s.run(f"b = mirror L1 about L0 {word}; print b")
    assert at(s, "L2.p2") == pytest.approx((5, 1))
    assert (len(s.document.constraints) > n) == (word != "noconstraint")
    s.document.undo()
    assert "L2" not in s.document.entities


def test_a_selected_axis_is_left_out_and_a_named_one_refused() -> None:
    s = sketch("add_line 4,0 4,5\nadd_line 0,0 3,1\nselect all\nmirror selection about L0")
    assert list(s.document.entities) == ["L0", "L1", "L2"]
    assert code(s, "mirror L0 L1 about L0") == "E1256"


def test_no_axis_is_refused() -> None:
    s: Session = sketch("add_line 0,0 1,0")
    with pytest.raises(AraelError):
        s.run("mirror L0")


def test_a_mirrored_ellipse_follows_in_its_direction_too() -> None:
    s = sketch("add_line 8,0 8,5\nadd_ellipse 0,0 4 2 30")
    before = freedom(s)
    s.run("mirror EA0 about L0 strict")
    assert freedom(s) == before
    s.run("lock L0.p1; lock L0.p2; xangle EA0 50")
    assert number(s, "EA1.rotation") % 180 == pytest.approx(130)
    s.run("unlock L0.p2; drag L0.p2 10,5")
    axis = number(s, "L0.angle")
    assert number(s, "EA1.rotation") % 180 == pytest.approx((2 * axis - 50) % 180)
