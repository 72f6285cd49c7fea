"""Copies of every kind of curve bring no freedom of their own."""

from __future__ import annotations

import pytest

from tests.sketch.groups.support import freedom, sketch

_KINDS = {
    "A0": "add_arc 3,3 0,3 1.5,4.5",
    "EA0": "add_earc 0,0 5,0 3 2 0",
    "S0": "add_spline 0,0 1,2 3,1 4,0",
}


@pytest.mark.parametrize("name", _KINDS)
@pytest.mark.parametrize(
    "command",
    ["pattern circular {} about P0 3", "pattern rect {} 2 10", "mirror {} about L0 strict"],
)
def test_copies_bring_no_freedom(name: str, command: str) -> None:
    s = sketch(f"add_point -3,-3\nadd_line 20,0 20,5\n{_KINDS[name]}")
    before = freedom(s)
    s.run(command.format(name))
    assert freedom(s) == before
