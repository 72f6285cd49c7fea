"""Every message of the language is shown by a Markdown case, and explained by a page."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from arael.diagnostics.explain import codes, explain

ROOT = Path(__file__).parents[1]
PACKAGES = ("syntax", "check")
RAISED = sorted(
    {
        code
        for package in PACKAGES
        for path in (ROOT / "arael" / package).rglob("*.py")
        for code in re.findall(r'"([EW]\d{4})"', path.read_text(encoding="utf-8"))
    }
)

# What one small text cannot show: bytes that are no text, files of a megabyte, several files.
OF_FILES = {
    "E0101": "tests/syntax/test_files.py",
    "E0102": "tests/syntax/test_files.py",
    "E0103": "tests/syntax/test_files.py",
    "E0104": "tests/syntax/test_files.py",
    "E0212": "tests/check/test_imports.py",
}


def shown() -> set[str]:
    texts = (path.read_text(encoding="utf-8") for path in (ROOT / "tests").rglob("*.md"))
    return {
        code for text in texts for code in re.findall(r"(?:error|warning)\[([EW]\d{4})\]", text)
    }


def test_there_are_codes() -> None:
    assert len(RAISED) > 80


def test_every_code_is_shown_by_a_markdown_case() -> None:
    assert sorted(set(RAISED) - shown() - OF_FILES.keys()) == []


@pytest.mark.parametrize("code", sorted(OF_FILES))
def test_codes_of_files_are_tested_where_files_are(code: str) -> None:
    assert code in (ROOT / OF_FILES[code]).read_text(encoding="utf-8")


@pytest.mark.parametrize("code", RAISED)
def test_every_code_has_a_page_with_a_title(code: str) -> None:
    assert code in codes()
    page = explain(code)
    assert re.match(rf"# {code}: [^\n]+[^\n.]\n", page)
    assert len(page) > 200
