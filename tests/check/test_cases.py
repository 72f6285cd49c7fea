"""Messages, as the Markdown files under ``cases/`` show them."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from arael.diagnostics.render import render
from tests.check.models import diagnostics

CASES = Path(__file__).parent / "cases"
CASE = re.compile(
    r"^## (?P<title>[^\n]+)\n(?:(?!^## ).)*?^```arael\n(?P<model>.*?)^```\n\s*"
    r"^```text\n(?P<expected>.*?)^```$",
    re.MULTILINE | re.DOTALL,
)


def cases() -> list[object]:
    found: list[object] = []
    for path in sorted(CASES.glob("*.md")):
        text = path.read_text(encoding="utf-8")
        matches = list(CASE.finditer(text))
        assert len(matches) == text.count("\n## "), f"{path}: a case is malformed"
        found += [
            pytest.param(m["model"], m["expected"], id=f"{path.stem}: {m['title']}")
            for m in matches
        ]
    return found


@pytest.mark.parametrize(("model", "expected"), cases())
def test_case(model: str, expected: str) -> None:
    assert render(diagnostics(model)).rstrip() == expected.rstrip()
