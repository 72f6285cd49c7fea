"""Messages about data files, as the Markdown files in ``messages`` show them.

The first ```` ```arael ```` block of a file is the model of all its cases (pose_graph_2d if
there is none). A case is a block of data of any text format
followed by a ```` ```text ```` block with what arael says of it. ``pytest --update`` writes the
present output into the files.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from arael.diagnostics.render import render
from tests.io.cases import found

FOLDER = Path(__file__).parent / "messages"
MODEL = re.compile(r"^```arael\n(.*?)^```$", re.MULTILINE | re.DOTALL)
CASE = re.compile(
    r"^## (?P<title>[^\n]*)\n(?:(?!^```|^#)[^\n]*\n)*?"
    r"^```(?P<kind>json|csv|g2o|bal|tum|kitti|euroc|bundle)\n(?P<data>.*?)^```\n\n```text\n(?P<said>.*?)^```$",
    re.MULTILINE | re.DOTALL,
)
CASES = [
    pytest.param(path, number, id=f"{path.stem}-{match['title'].replace(' ', '-')}")
    for path in sorted(FOLDER.glob("*.md"))
    for number, match in enumerate(CASE.finditer(path.read_text()))
]


@pytest.mark.parametrize(("path", "number"), CASES)
def test_message(path: Path, number: int, tmp_path: Path, update: bool) -> None:
    text = path.read_text()
    case = list(CASE.finditer(text))[number]
    model = MODEL.search(text)
    said = render(found(model[1] if model else "", case["data"], case["kind"], tmp_path))
    if said != case["said"] and update:
        start, end = case.span("said")
        path.write_text(text[:start] + said + text[end:])
        return
    assert said == case["said"]


def test_every_heading_is_a_case() -> None:
    headings = sum(path.read_text().count("\n## ") for path in FOLDER.glob("*.md"))
    assert headings == len(CASES) > 30
