"""A drag has no solution at infinity: there everything is small relative to the drawing's size."""

import pytest

from arael.sketch.commands.session import Session

# A frame around a fixed circle, whose corner is pulled to the other side of the circle; one of its
# lines is free to grow.
LINES = """
add_arc -2.171,-5.787 -7.292,-3.529 -8.386,-8.054
add_earc_center 7.022,0.430 2.876 1.141 2.287 15.982 139.421
add_rect A0.start EA0.end hv
trim EA0 3.532,-9.020 nopin
add_circle3t L3 L1 L2
delete C4
fix A1
sweep A0 driven
pattern circular L2 about A0.start 3
pattern circular A0 about L1.p2 3
offset_line L5 0.153
"""


@pytest.fixture
def session() -> Session:
    made = Session()
    made.run(LINES)
    assert 20 < made.editor.layout.size < 40
    return made


def test_by_a_command(session: Session) -> None:
    session.editor.drag({"L0.p1": (5.088, 4.438)})
    assert session.editor.layout.size < 40
    assert session.editor.solver.holds(1e-8)


def test_by_the_pointer(session: Session) -> None:
    with session.editor.dragging(["L0.p1"]) as drag:
        drag.to((5.088, 4.438))
        assert session.editor.layout.size < 40
        assert drag.to((-2.1, -5.7)).status == "solved"
    assert session.editor.layout.size < 40
