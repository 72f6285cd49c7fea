"""Distances of lines and circles: what they hold, and what they leave when they are deleted."""

from __future__ import annotations

import math

import pytest

from arael.sketch import Sketch
from arael.sketch.commands.session import Session
from arael.sketch.document.saved import from_json, to_json


def said(session: Session, line: str) -> str:
    return "\n".join(reply.text for reply in session.run(line))


def circle(session: Session, name: str) -> tuple[float, float, float]:
    x, y, r = session.document.numbers_of(name).tolist()
    return x, y, r


def apart(session: Session, one: str = "A0", other: str = "A1") -> float:
    return math.dist(circle(session, one)[:2], circle(session, other)[:2])


@pytest.mark.parametrize(
    ("drawing", "lines"),
    [
        ("add_rect 0,0 5,3 hv", "L0 L2"),
        ("add_polygon 6 0,0 4,0", "L0 L3"),
        ("add_slot 0,0 6,0 2", "L0 L1"),
        ("add_rectcenter 0,0 4,3 hv", "L0 L2"),
        ("add_line 0,0 5,0; add_line 0,2 0,6; add_line 3,3 3,8; perp L0 L1; perp L0 L2", "L1 L2"),
    ],
)
def test_lines_that_are_parallel_already_take_a_distance(drawing: str, lines: str) -> None:
    session = Session()
    session.run(drawing)
    free = session.editor.judge.freedoms().total
    value = 1.1 * session.editor.measure("distance", lines.split())
    reply = said(session, f"distance {lines} {value!r}")
    assert "notice" not in reply
    found = session.editor.judge.freedoms()
    assert (found.total, found.redundant) == (free - 1, ())
    name = next(n for n, d in session.document.dimensions.items() if d.args == tuple(lines.split()))
    for change in (f"distance {lines} {value!r} force", f"distance {lines} >= 0.1"):
        session.run(change)
    session.run(f"distance {lines} derived")
    assert session.document.dimensions[name].derived
    assert session.editor.judge.freedoms().total == free


def test_lines_stay_parallel_when_what_made_them_so_is_deleted() -> None:
    session = Session()
    session.run("add_rect 0,0 5,3 hv; distance L0 L2 4; delete CL0H CL2H; drag L0.p2 6,2")
    a, b = (session.document.numbers_of(name) for name in ("L0", "L2"))
    u, v = a[2:] - a[:2], b[2:] - b[:2]
    assert abs(u[0] * v[1] - u[1] * v[0]) < 1e-8
    assert session.editor.measure("distance", ("L0", "L2")) == pytest.approx(4)


def test_a_gap_of_circles_around_one_centre() -> None:
    session = Session()
    session.run("add_circle 0,0 5; add_circle 0,0 8")
    assert said(session, "distance A0 A1 4") == "Added d0: distance A0 A1 = 4"
    assert circle(session, "A1")[2] - circle(session, "A0")[2] == pytest.approx(4)
    assert session.editor.judge.freedoms().redundant == ()
    session.run("undo; delete C0")
    assert "notice: A0 and A1 stay concentric as long as d0 is there" in said(
        session, "distance A0 A1 4"
    )
    session.run("drag A1.center 3,1")
    assert apart(session) < 1e-9


@pytest.mark.parametrize(
    ("second", "mode", "gap"),
    [
        ("12,0 2", "outside", lambda d, a, b: d - a - b),
        ("12,0 7", "outside", lambda d, a, b: d - a - b),  # they cross, nearer to side by side
        ("3,0 2", "inside", lambda d, a, b: a - b - d),
        ("3,0 20", "inside", lambda d, a, b: b - a - d),
    ],
)
def test_the_distance_of_circles_is_from_edge_to_edge(second, mode, gap) -> None:
    session = Session()
    session.run(f"add_circle 0,0 10 noconnect; add_circle {second} noconnect; distance A0 A1 3")
    for value in (3.0, 1.0, 6.0):
        session.run(f"distance A1 A0 {value}")
        radii = circle(session, "A0")[2], circle(session, "A1")[2]
        assert gap(apart(session), *radii) == pytest.approx(value)
        assert session.editor.measure("distance", ("A0", "A1")) == pytest.approx(value)
    assert session.document.dimensions["d0"].mode == mode
    assert not session.document.constraints
    session.run("distance A0 A1 >= 2; drag A1.center 0,1")
    radii = circle(session, "A0")[2], circle(session, "A1")[2]
    assert gap(apart(session), *radii) > 2 - 1e-9
    session.run("delete d0")
    assert session.editor.judge.freedoms().total == 6


def test_a_point_stays_inside_or_outside_and_a_line_on_its_side() -> None:
    session = Session()
    session.run("add_circle 0,0 5; lock A0.center; radius A0 5")
    session.run("add_point 1,1 noconnect; add_point 6,6 noconnect; add_line -9,7 9,8 noconnect")
    session.run("distance P0 A0 1; distance A0 P1 2; distance L0 A0 3")
    session.run("distance P0 A0 4; distance P1 A0 5; distance A0 L0 1")
    (x, y), (u, v) = (session.document.numbers_of(name).tolist() for name in ("P0", "P1"))
    assert math.hypot(x, y) == pytest.approx(1)
    assert math.hypot(u, v) == pytest.approx(10)
    x1, y1, x2, y2 = session.document.numbers_of("L0").tolist()
    off = (x1 * y2 - x2 * y1) / math.hypot(x2 - x1, y2 - y1)
    assert off == pytest.approx(-6)  # as drawn: the centre is on the right


def test_what_is_measured_of_crossing_circles_is_no_distance() -> None:
    session = Session()
    session.run("add_circle 0,0 10 noconnect; add_circle 12,0 7 noconnect")
    session.run("distance A0 A1 derived")
    assert session.editor.measure("distance", ("A0", "A1")) == 0.0
    assert circle(session, "A1") == (12.0, 0.0, 7.0)


def test_edge_distances_are_drawn_saved_and_loaded() -> None:
    sketch = Sketch()
    sketch.run("add_circle 0,0 5; add_circle 20,0 3; distance A0 A1 4; add_point 0,8 noconnect")
    sketch.run("distance P0 A0 2; add_line -9,-7 9,-8 noconnect; distance L0 A0 3")
    sketch.run("add_circle 1,0 2 noconnect; distance A2 A0 1")
    for value in ("4", "2", "3", "1"):
        assert f">{value}<" in sketch._repr_svg_()
    again = from_json(to_json(sketch.document))
    assert list(again.dimensions.values()) == list(sketch.document.dimensions.values())
