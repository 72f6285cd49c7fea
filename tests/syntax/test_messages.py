"""Every syntax message, as the Markdown files in ``messages`` show them."""

from pathlib import Path

import pytest

from arael.diagnostics.records import AraelError, Source
from arael.diagnostics.render import render
from arael.syntax.parser import parse
from tests.mdtest import Case, check_case, find_cases

CASES = find_cases(Path(__file__).parent / "messages")


def syntax_messages(name: str, text: str) -> str:
    try:
        parse(Source(name, text))
    except AraelError as error:
        return render(error.diagnostics, color=False, width=100)
    return ""


@pytest.mark.parametrize("case", CASES, ids=str)
def test_message(case: Case, update: bool) -> None:
    check_case(case, syntax_messages, update)


def test_there_are_cases() -> None:
    assert len(CASES) > 60
