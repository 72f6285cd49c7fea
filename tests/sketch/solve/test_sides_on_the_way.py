"""Sides on the way to a value that is far away."""

from __future__ import annotations

import pytest

from arael.diagnostics.records import AraelError
from arael.sketch.commands.session import Session
from tests.sketch.properties.generator import snapshot

BRACKET = """
add_line -30,-20 30,-20; add_line 30,-8; add_line -14,-8; add_line -14,20
add_line -30,20; add_line -30,-20
horizontal L0 L2 L4; vertical L1 L3 L5
fillet L2.p2 6
distance L2.p1 L0 60
"""


def test_a_prediction_does_not_carry_a_line_past_zero_length() -> None:
    session = Session()
    session.run(BRACKET)
    before = snapshot(session.document)
    # 40 would put the upper end of L3, tangent to the fillet, below its lower one
    with pytest.raises(AraelError) as caught:
        session.run("length L5 40")
    assert caught.value.diagnostics[0].code == "E1233"
    assert snapshot(session.document) == before


def test_what_only_a_collapse_would_solve_is_impossible() -> None:
    session = Session()
    session.run("add_rect 0,0 20,10 hv")
    with pytest.raises(AraelError) as caught:
        session.run("parallel L0 L1")
    found = caught.value.diagnostics[0]
    assert found.code == "E1231"
    assert "`CL0H`" in found.message
    assert "`CL1V`" in found.message
