"""Messages about models of several files, as imports.md shows them.

``pytest --update`` writes the present output into the file.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from arael.compiler import imports
from arael.diagnostics.records import AraelError
from arael.diagnostics.render import render
from arael.loading import load_compiled

PAGE = Path(__file__).parent / "imports.md"
CASE = re.compile(r"^## (?P<title>[^\n]*)\n(?P<body>.*?)^```text\n(?P<said>.*?)^```$", re.M | re.S)
FILE = re.compile(r"(?:^`(?P<name>[\w./]+)`:\n\n)?^```arael\n(?P<text>.*?)^```$", re.M | re.S)
CASES = list(CASE.finditer(PAGE.read_text(encoding="utf-8")))


@pytest.mark.parametrize("number", range(len(CASES)), ids=[c["title"] for c in CASES])
def test_message(
    number: int, tmp_path: Path, update: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = PAGE.read_text(encoding="utf-8")
    case = list(CASE.finditer(text))[number]
    bound = re.search(r"with a bound of (\d+):", case["body"])
    if bound is not None:
        monkeypatch.setattr(imports, "MAX_FILES", int(bound[1]))
    for file in FILE.finditer(case["body"]):
        path = tmp_path / (file["name"] or "main.arael")
        path.parent.mkdir(exist_ok=True)
        path.write_text(file["text"], encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    with pytest.raises(AraelError) as caught:
        load_compiled("main.arael", interpret=True)
    said = render(caught.value.diagnostics)
    if said != case["said"] and update:
        start, end = case.span("said")
        PAGE.write_text(text[:start] + said + text[end:], encoding="utf-8")
        return
    assert said == case["said"]


def test_every_heading_is_a_case_and_every_code_is_shown() -> None:
    text = PAGE.read_text(encoding="utf-8")
    assert len(CASES) == text.count("\n## ")
    assert {"E0212", "E0220", "E0221"} <= set(re.findall(r"error\[(E\d+)\]", text))
