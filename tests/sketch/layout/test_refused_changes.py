"""A refused command leaves the equations as they were, not only the numbers."""

import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.commands.session import Session

PATTERN = [
    "add_earc_center 0,0 3 1 30 0 100",
    "pattern rect EA0 2 8",
    "lock EA0.start",
    "lock EA0.end",
]


@pytest.mark.parametrize("angle", [-149.83, 100, 150, 200])
def test_half_turns_of_an_image_that_was_tried_are_not_kept(angle: float) -> None:
    """The search for what is to blame laid the image out half a turn away from where it is."""
    session = Session()
    for line in PATTERN:
        session.run(line)
    try:
        session.run(f"rotate EA1 about 8,0 {angle}")
    except AraelError as refused:
        assert refused.diagnostics[0].code in ("E1231", "E1234")
    session.editor.layout.check()
    system = session.editor.layout.linearisation()
    assert abs(system.residuals).max() < 1e-9
