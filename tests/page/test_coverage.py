"""Every tool, action, key, snap, panel and format of the page has a test in a browser.

Tests declare what they exercise (`tests.sketch.browser.exercised`); coverage.md is the table of it.
"""

from __future__ import annotations

import fnmatch
import importlib
import json
import subprocess
from collections import defaultdict
from inspect import isfunction
from pathlib import Path

from tests import optional

HERE = Path(__file__).parent
TABLE = HERE / "coverage.md"
BROWSER = HERE.parent / "sketch" / "browser"

HEAD = """# What a person can use on the page, and the test of each in a browser

Made by `pytest --update tests/page/test_coverage.py` from the page's own tables and from what tests
declare (`exercises`). A test fails if the page has not run what it declares; files are those of
`tests/sketch/browser`.
"""

TITLES = {
    "tool": "Tools",
    "action": "Actions",
    "key": "Keys",
    "snap": "Snaps",
    "panel": "Panels",
    "export": "Export",
    "import": "Import",
    "pointer": "Pointer and drawing keys",
}


def parts() -> dict[str, str]:
    """Title of every part, in the order of the page."""
    node = optional.program("node")
    script = str(HERE / "inventory.js")
    made = subprocess.run([node, script], capture_output=True, encoding="utf-8", check=True).stdout
    return {name: title for name, title in json.loads(made)}


def declared() -> dict[str, list[str]]:
    """Tests of every part that is declared; a part may be a pattern."""
    found: defaultdict[str, list[str]] = defaultdict(list)
    for file in sorted(BROWSER.glob("test_*.py")):
        module = importlib.import_module(f"tests.sketch.browser.{file.stem}")
        for name, test in vars(module).items():
            for part in test.exercised if isfunction(test) and hasattr(test, "exercised") else ():
                found[part].append(f"{file.name}::{name}")
    return found


def table(titles: dict[str, str], tests: dict[str, list[str]]) -> str:
    """The page on coverage."""
    lines = [HEAD]
    for kind, title in TITLES.items():
        lines += [f"\n## {title}\n", "| Part | Title | Tests |", "|---|---|---|"]
        for part, text in titles.items():
            of, name = part.split(":", 1)
            if of == kind:
                found = "<br>".join(f"`{one}`" for one in of_part(part, tests)) or "none yet"
                lines.append(f"| `{name}` | {text} | {found} |".replace("`|`", "`\\|`"))
    return "\n".join(lines) + "\n"


def of_part(part: str, tests: dict[str, list[str]]) -> list[str]:
    """Tests of a part: those that name it before those of a pattern."""
    named = tests.get(part, [])
    fitting = [one for one in tests if "*" in one and fnmatch.fnmatchcase(part, one)]
    return [*named, *(test for one in fitting for test in tests[one] if test not in named)]


def test_everything_on_the_page_has_a_test_in_a_browser() -> None:
    tests = declared()
    assert [one for one in parts() if not of_part(one, tests)] == []


def test_what_tests_declare_is_on_the_page() -> None:
    titles = parts()
    assert [one for one in declared() if not fnmatch.filter(titles, one)] == []


def test_the_table_of_tests_is_up_to_date(update: bool) -> None:
    made = table(parts(), declared())
    if update:
        TABLE.write_text(made, encoding="utf-8")
    assert TABLE.read_text(encoding="utf-8") == made, "run pytest --update"
