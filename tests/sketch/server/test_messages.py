"""Every message of the server has a page, and a test that raises it."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from arael.diagnostics.explain import codes, explain

ROOT = Path(__file__).parents[3]
SOURCES = [
    *(ROOT / "arael" / "sketch" / "server").glob("*.py"),
    *(ROOT / "arael" / "sketch" / "agents").glob("*.py"),
    ROOT / "arael" / "sketch" / "notebook.py",
    ROOT / "arael" / "cli" / "sketch.py",
]
TESTS = [*Path(__file__).parent.glob("*.py"), *(ROOT / "tests" / "sketch" / "agents").glob("*.py")]


def codes_in(paths: list[Path]) -> set[str]:
    return {
        code
        for path in paths
        if path.name != Path(__file__).name
        for code in re.findall(r"E14\d\d", path.read_text(encoding="utf-8"))
    }


def test_every_code_has_a_page_and_a_test() -> None:
    raised = codes_in(SOURCES)
    assert len(raised) > 12
    assert raised == {code for code in codes() if code.startswith("E14")}
    assert raised - codes_in(TESTS) == set()


@pytest.mark.parametrize("code", sorted(code for code in codes() if code.startswith("E14")))
def test_a_page_begins_with_its_code_and_a_title(code: str) -> None:
    page = explain(code)
    assert re.match(rf"# {code}: [a-z][^\n.]*\n\n", page) and len(page) > 200
