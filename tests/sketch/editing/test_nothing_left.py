"""What is tiny beside the rest of the drawing has a direction, which it keeps."""

import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.commands.session import Session


def test_a_tiny_line_is_not_made_a_point() -> None:
    session = Session()
    session.run("add_line 0,0 1e-6,0; add_line 0,3 1000,0; add_line L0.p1 0,-5")
    assert session.editor.layout.size > 500
    with pytest.raises(AraelError, match="impossible together with `C0`") as refused:
        session.run("coincident L2.p1 L0.p2")
    assert refused.value.diagnostics[0].code == "E1231"
    assert session.document.numbers_of("L0").tolist() == [0.0, 0.0, 1e-6, 0.0]
    # and it does not stand in the way of anything else
    session.run("move L0 @3,3; length L0 2e-6")
    start, end = session.document.numbers_of("L0").reshape(2, 2)
    assert start == pytest.approx((3, 3))
    assert abs(end - start).max() == pytest.approx(2e-6)


def test_an_ellipse_is_not_made_flat() -> None:
    """Its contacts with other curves are lost in rounding."""
    session = Session()
    session.run("add_ellipse 0,0 3 1 20")
    before = session.document.numbers_of("EA0").copy()
    with pytest.raises(AraelError) as refused:
        session.run("radius_b EA0 1e-6")
    assert refused.value.diagnostics[0].code == "E1220"
    assert (session.document.numbers_of("EA0") == before).all()
    session.run("radius_b EA0 1e-5")
    assert session.document.numbers_of("EA0")[3] == pytest.approx(1e-5)
