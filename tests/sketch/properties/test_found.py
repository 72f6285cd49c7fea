"""What random sketches brought to light, each as the shortest script that shows it."""

from __future__ import annotations

import numpy as np
import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.commands.session import Session
from tests.sketch.properties.generator import snapshot


def sketch(script: str) -> Session:
    session = Session()
    session.run(script)
    return session


def refused(session: Session, line: str) -> str:
    """Code of the refusal, which changes nothing."""
    before = snapshot(session.document)
    with pytest.raises(AraelError) as caught:
        session.run(line)
    assert snapshot(session.document) == before
    return caught.value.diagnostics[0].code


@pytest.mark.parametrize("line", ["sweep A0 90", "arc_length A0 3", "midpoint P0 A0"])
def test_a_circle_has_no_start_and_no_end(line: str) -> None:
    session = sketch("add_circle 0,0 2; add_point 5,5")
    assert refused(session, line) in ("E1222", "E1254")


def test_concentric_does_not_turn_a_tangent_circle_inside_out() -> None:
    session = sketch("add_arc -6.795,4.092 0.894,-5.588 5.956,0.332; add_circle 0.953,8.289 1.245")
    session.run("tangent A1 A0")
    assert refused(session, "concentric A1 A0") == "E1220"


def test_a_circle_about_the_end_of_a_line_is_not_tangent_to_it() -> None:
    session = sketch("add_circle -9,2 0.5; add_line A0.center -3,-2.6")
    assert refused(session, "tangent L0 A0") == "E1220"


def test_an_arc_does_not_end_in_its_center_by_way_of_another_point() -> None:
    session = sketch("add_arc 5,0 0,5 3.5355339,3.5355339; add_point 5,0; add_line 5,0 9,9")
    assert refused(session, "coincident A0.center P0") == "E1220"


def test_the_size_of_points_in_one_place_is_that_of_what_is_around_them() -> None:
    session = sketch("add_point 3.5,5.6; add_point -8.5,-8.0; add_circle -1.5,-0.7 2")
    session.run("vertical P1 P0; horizontal A0.center P0; coincident P1 A0.center")
    assert session.editor.layout.size == pytest.approx(4.0)
    assert np.ptp(session.document.values) > 1.0


def test_ranges_of_directions() -> None:
    session = sketch("add_line 0,0 5,-0.001; xangle L0 >= 1.3")
    assert refused(session, "horizontal L0")  # 0 degrees, not 360


def test_what_touches_an_ellipse_does_not_creep_when_something_else_is_deleted() -> None:
    session = sketch("add_earc_center -1.097,-4.118 3.323 1.942 11.517 18.786 227.841")
    session.run("add_circle -6.739,5.259 0.576; add_circle -8.613,0.030 2.388")
    session.run("distance A0 A1 driven\ntangent A1 EA0\ndelete C0")
    before = snapshot(session.document)
    assert session.editor.solve().moved == ()
    assert snapshot(session.document) == before


def test_a_lock_that_adds_nothing_is_redundant() -> None:
    session = sketch("add_line 0,0 5,0\nlock L0.p1\nhorizontal L0\nlength L0 5")
    assert refused(session, "lock L0.p2") == "E1230"


def test_a_drag_leaves_something_of_a_line() -> None:
    session = sketch("add_line 0,0 5,0; lock L0.p2; horizontal L0")
    with session.editor.dragging(["L0.p1"]) as drag:
        for x in (2.0, 4.0, 4.9, 5.0, 5.0, 5.0):
            drag.to((x, 0.0))
    assert session.document.numbers_of("L0")[0] < 5.0 - 1e-8
    try:
        session.editor.drag({"L0.p1": (5.0, 0.0)})
    except AraelError as error:
        assert error.diagnostics[0].code == "E1220"
    assert session.document.numbers_of("L0")[0] < 5.0


def test_the_distance_of_an_arcs_center_from_a_line_is_not_that_of_two_arcs() -> None:
    session = sketch("add_arc 5,0 0,5 3.5355339,3.5355339; add_line 10,0 10,7")
    session.run("distance A0.center L0 4")
    assert session.editor.measure("distance", ("A0.center", "L0")) == pytest.approx(4.0)
    session.run("delete d0; distance A0.center L0 >= 6")
    assert session.editor.measure("distance", ("A0.center", "L0")) == pytest.approx(6.0)
