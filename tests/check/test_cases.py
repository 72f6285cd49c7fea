"""Messages, as the Markdown files in ``cases`` show them."""

from __future__ import annotations

from pathlib import Path

import pytest

from arael.diagnostics.render import render
from tests.check.models import diagnostics
from tests.mdtest import Case, check_case, find_cases

CASES = find_cases(Path(__file__).parent / "cases")


def messages(name: str, text: str) -> str:
    return render(diagnostics(text))


@pytest.mark.parametrize("case", CASES, ids=str)
def test_message(case: Case, update: bool) -> None:
    check_case(case, messages, update)


def test_there_are_cases() -> None:
    assert len(CASES) > 50
