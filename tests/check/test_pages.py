"""Each code has a page, whose wrong example is wrong in that way and whose right one is right."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from arael.diagnostics.explain import codes, explain
from tests.check.models import diagnostics

ROOM = Path(__file__).parents[2] / "arael" / "check"
RAISED = {c for p in ROOM.glob("*.py") for c in re.findall(r'"([EW]0\d{3})"', p.read_text())}
BLOCK = re.compile(r"^```arael\n(.*?)^```$", re.MULTILINE | re.DOTALL)
WITHOUT_EXAMPLE = {"E0212", "E0607"}  # several files; a hundred functions


def test_every_code_raised_has_a_page() -> None:
    assert RAISED
    assert set(codes()) >= RAISED


@pytest.mark.parametrize("code", sorted(RAISED - WITHOUT_EXAMPLE))
def test_examples(code: str) -> None:
    wrong, right = BLOCK.findall(explain(code))
    assert code in [d.code for d in diagnostics(wrong)]
    assert [d for d in diagnostics(right) if d.code == code or d.severity == "error"] == []
