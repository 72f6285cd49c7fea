"""Coincidences and locks are named where no equation is to blame."""

from __future__ import annotations

import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.commands.session import Session
from tests.sketch.properties.generator import snapshot

LOCKED = "add_line 0,0 5,0; lock L0.p1; lock L0.p2; add_line 5,0 9,3"
ARC = "add_arc 0,0 4,0 2,2; add_arc 4,0 8,0 6,2; lock A0.start; lock A0.center"


@pytest.mark.parametrize(
    ("drawn", "asked", "code", "named"),
    [
        (LOCKED, "length L0 7", "E1231", ("C0", "C1")),
        (LOCKED, "length L0 5", "E1230", ("C0", "C1")),
        (LOCKED, "vdistance L0.p2 L1.p1 3", "E1231", ("C2",)),
        ("add_line 0,0 5,0; fix L0", "horizontal L0", "E1230", ("C0",)),
        ("add_line 0,0 5,0; fix L0", "length L0 9", "E1231", ("C0",)),
        (ARC, "radius A0 2.1", "E1231", ("C2", "C3")),
    ],
)
def test_joints_that_are_to_blame_are_named(
    drawn: str, asked: str, code: str, named: tuple[str, ...]
) -> None:
    session = Session()
    session.run(drawn)
    before = snapshot(session.document)
    with pytest.raises(AraelError) as caught:
        session.run(asked)
    found = caught.value.diagnostics[0]
    assert found.code == code
    assert {word.strip("`,") for word in found.message.split() if word.startswith("`C")} == {*named}
    assert snapshot(session.document) == before
    # each of them is proven: without it, the others let the new one in
    for name in named:
        session.run(f"delete {name}; {asked}; undo 2")
        assert snapshot(session.document) == before
