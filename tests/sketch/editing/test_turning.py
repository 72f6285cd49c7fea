"""Lines keep a length when they get quite another direction, or the relation is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.commands.session import Session
from arael.sketch.document.saved import to_json

LINES = "add_line 0,0 5,0; add_line 1,1 1,4 noconnect; add_line 0,-1 5,-1 noconnect"
#: Command -> the line that turns, its length, its direction (degrees, modulo 180).
TURNS = {
    "vertical L0": ("L0", 5, 90),
    "vertical L0.p1 L0.p2": ("L0", 5, 90),
    "horizontal L1": ("L1", 3, 0),
    "parallel L0 L1": ("L1", 3, 0),
    "perpendicular L0 L2": ("L2", 5, 90),
}


def line(session: Session, name: str) -> tuple[float, float]:
    x1, y1, x2, y2 = session.document.numbers_of(name)
    return math.hypot(x2 - x1, y2 - y1), math.degrees(math.atan2(y2 - y1, x2 - x1)) % 180


@pytest.mark.parametrize("command", TURNS)
@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_a_line_turns_and_keeps_its_length(command: str, scale: float) -> None:
    session = Session()
    session.run(LINES)
    if scale != 1.0:
        session = Session()
        with session.document.transaction("make"):
            for numbers in ((0, 0, 5, 0), (1, 1, 1, 4), (0, -1, 5, -1)):
                session.document.add_entity("line", np.array(numbers) * scale)
    session.run(command)
    name, length, direction = TURNS[command]
    found = line(session, name)
    assert found[0] == pytest.approx(length * scale, rel=1e-6)
    assert math.remainder(found[1] - direction, 180) == pytest.approx(0, abs=1e-6)


def test_a_line_across_another_lies_along_it() -> None:
    session = Session()
    session.run(LINES)
    session.run("collinear L0 L1")
    (length, direction), (other, along) = line(session, "L0"), line(session, "L1")
    assert (length, other) == pytest.approx((5, 3), rel=0.05)
    assert math.remainder(direction - along, 180) == pytest.approx(0, abs=1e-6)


def test_what_is_connected_moves_along() -> None:
    session = Session()
    session.run("add_line 0,0 5,0 5,3; vertical L0; length L0 3")
    assert line(session, "L0") == pytest.approx((3, 90))
    joint = session.document.numbers_of("L1")[:2]
    assert joint.tolist() == session.document.numbers_of("L0")[2:].tolist()


def test_it_turns_about_the_end_that_is_held() -> None:
    session = Session()
    session.run("add_line 1,2 6,2; lock L0.p1; vertical L0")
    assert session.document.numbers_of("L0").tolist() == pytest.approx([1, 2, 1, 7])


@pytest.mark.parametrize(
    "line_", ["vertical L0", "parallel L0 L1; vertical L0", "xangle L0 0; vertical L0 force"]
)
def test_a_direction_that_leaves_nothing_is_refused(line_: str) -> None:
    session = Session()
    session.run("add_line 0,0 5,0; add_line 0,1 5,1 noconnect; horizontal L0; horizontal L1")
    before = to_json(session.document)
    with pytest.raises(AraelError):
        session.run(line_)
    assert to_json(session.document) == before


def test_a_line_that_collapses_by_a_point_is_refused() -> None:
    session = Session()
    session.run("add_line 0,0 5,0; add_point 5,0; lock L0.p1")
    before = to_json(session.document)
    with pytest.raises(AraelError) as caught:
        session.run("lock P0 0,0")
    assert caught.value.diagnostics[0].code in ("E1220", "E1231", "E1232", "E1233", "E1234")
    assert to_json(session.document) == before


def test_a_value_that_goes_to_nothing_is_refused() -> None:
    session = Session()
    session.run("add_line 0,0 5,0; param w 5; length L0 w")
    before = to_json(session.document)
    with pytest.raises(AraelError):
        session.run("param w 0")
    assert to_json(session.document) == before


@pytest.mark.parametrize("angle", [-20, -5, 0, 5, 20, 160, 180])
@pytest.mark.parametrize("corner", ["start", "end"])
@pytest.mark.parametrize("turned", [False, True])
def test_a_line_across_an_arc_becomes_tangent_at_its_length(
    angle: float, corner: str, turned: bool
) -> None:
    session = Session()
    session.run("add_arc -5,0 5,0 0,-5 notangent")  # half a circle
    x = session.document.values[session.document.point_at(f"A0.{corner}")]
    away = f"{x + 4 * math.cos(math.radians(angle))},{4 * math.sin(math.radians(angle))}"
    ends = f"{away} {x},0" if turned else f"{x},0 {away}"
    session.run(f"add_line {ends} notangent")
    session.run("tangent L0 A0")
    length, direction = line(session, "L0")
    assert length == pytest.approx(4, abs=1e-6)
    assert direction % 180 == pytest.approx(90, abs=1e-6)
    assert session.editor.measure("radius", ["A0"]) == pytest.approx(5, abs=1e-6)
    # It goes on where the arc ends, instead of back along it.
    other = np.array(session.document.numbers_of("L0")).reshape(2, 2)[0 if turned else 1]
    if abs(math.sin(math.radians(angle))) < 0.1:
        assert other[1] == pytest.approx(4, abs=1e-6)


def test_a_figure_that_is_free_turns_as_a_whole() -> None:
    # Forty rectangles, corner to corner, of which the first is 80 degrees off.
    turn = complex(math.cos(math.radians(80)), math.sin(math.radians(80)))
    session, corner = Session(), 0j
    for k in range(40):
        width, height = 2 + 7 * k % 9, 1 + 5 * k % 6
        places = [turn * (corner + one) for one in (0, width, width + 1j * height)]
        session.run("add_rect3 " + " ".join(f"{z.real:.17g},{z.imag:.17g}" for z in places))
        corner += width + 1j * height
    before = [line(session, name) for name in session.document.entities]
    session.run("horizontal L0")
    after = [line(session, name) for name in session.document.entities]
    for (was, old), (now, new) in zip(before, after, strict=True):
        assert now == pytest.approx(was, rel=1e-9)
        assert math.remainder(new - old + 80, 180) == pytest.approx(0, abs=1e-6)
