"""Tests of messages as Markdown: prose, a model, and its expected messages.

A case is an ```` ```arael ```` block followed by a ```` ```text ```` block, under a heading that
names it. The text block holds the rendered diagnostics, and is empty where there are none. Files
are found by `find_cases`; a test runs one case with `check_case`::

    @pytest.mark.parametrize("case", find_cases(Path(__file__).parent), ids=str)
    def test_message(case, update):
        check_case(case, run, update)

where ``run(name, text)`` returns the diagnostics of the model `text` as text. ``pytest --update``
writes the present output into the files.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

_CASE = re.compile(
    r"^```arael[^\n]*\n(?P<model>.*?)^```\n(?P<between>(?:(?!^```|^#)[^\n]*\n)*?)"
    r"^```text\n(?P<expected>.*?)^```$",
    re.MULTILINE | re.DOTALL,
)
_HEADING = re.compile(r"^#+ (.*)$", re.MULTILINE)

Run = Callable[[str, str], str]


@dataclass(frozen=True)
class Case:
    """The `number`-th case of a file, from 0."""

    path: Path
    number: int
    heading: str
    line: int
    model: str
    expected: str

    def __str__(self) -> str:
        slug = re.sub(r"\W+", "-", self.heading.lower()).strip("-")
        return f"{self.path.stem}-{slug}-L{self.line}"


def cases_of(path: Path) -> list[Case]:
    """Cases of one Markdown file, in order."""
    text = path.read_text(encoding="utf-8")
    headings = [(m.start(), m[1]) for m in _HEADING.finditer(text)]
    found = []
    for number, match in enumerate(_CASE.finditer(text)):
        heading = next((h for at, h in reversed(headings) if at < match.start()), path.stem)
        line = text.count("\n", 0, match.start()) + 1
        found.append(Case(path, number, heading, line, match["model"], match["expected"]))
    return found


def find_cases(folder: Path) -> list[Case]:
    """Cases of all Markdown files in `folder` and below it, README files left out."""
    paths = sorted(p for p in folder.rglob("*.md") if p.name != "README.md")
    return [case for path in paths for case in cases_of(path)]


def check_case(case: Case, run: Run, update: bool = False, name: str = "model.arael") -> None:
    """Compare the output of `run` for the case's model with the expected output in the file."""
    actual = run(name, case.model)
    actual = actual if not actual or actual.endswith("\n") else actual + "\n"
    if update and actual != case.expected:
        _rewrite(case, actual)
        return
    assert actual == case.expected, f"{case.path}:{case.line}: {case.heading}"


def _rewrite(case: Case, actual: str) -> None:
    text = case.path.read_text(encoding="utf-8")
    match = list(_CASE.finditer(text))[case.number]
    start, end = match.span("expected")
    case.path.write_text(text[:start] + actual + text[end:], encoding="utf-8")
