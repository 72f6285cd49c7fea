"""An area follows the joints of its outline, wherever a change has just put the ends."""

import math

import pytest

from arael.sketch.commands.session import Session


def on_circle(degrees: float) -> str:
    """A point of the circle of radius 2 about the origin."""
    angle = math.radians(degrees)
    return f"{2 * math.cos(angle):.9f},{2 * math.sin(angle):.9f}"


def test_an_arc_that_a_change_puts_far_from_its_neighbour_keeps_its_direction() -> None:
    """Amid `extend`, the other end of the short arc is nearer to its neighbour than its own."""
    session = Session()
    for start, end in ((0, 180), (180, 358), (358, 360)):
        session.run(f"add_arc {on_circle(start)} {on_circle(end)} {on_circle((start + end) / 2)}")
    session.run("area A0 A1 A2 driven")
    session.run("set_driven d0 12.5")
    session.run("add_line 0,0 1.9,-1")
    session.run("extend A2 0,-3 nopin")
    editor = session.editor
    value = editor.document.dimensions["d0"].value
    assert value is not None
    radius = float(editor.document.numbers_of("A2")[-1])
    assert editor.measure("area", ("A0", "A1", "A2")) == pytest.approx(math.pi * radius**2)
    assert value.number == pytest.approx(math.pi * radius**2)
    assert abs(editor.layout.linearisation().residuals).max() < 1e-9
