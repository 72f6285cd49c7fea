"""The page for users of SciPy counts the lines of its programs."""

from __future__ import annotations

import re
from pathlib import Path

PAGE = Path(__file__).parents[1] / "docs" / "from_scipy.md"


def test_the_table_of_programs_has_their_lines() -> None:
    text = PAGE.read_text(encoding="utf-8")
    section = text.partition("## Five common programs")[2].partition("\n## ")[0]
    listed = re.findall(r"^\| [^|]+ \| (\d+) \| (\d+) \|", section, re.MULTILINE)
    counted = []
    for block in re.findall(r"```python\n(.*?)```", section, re.DOTALL):
        scipy, ours = block.partition("# SciPy\n")[2].split("# arael\n")
        counted.append(tuple(str(len(re.findall(r"\S.*", part))) for part in (scipy, ours)))
    assert len(counted) == 5 and listed == counted
