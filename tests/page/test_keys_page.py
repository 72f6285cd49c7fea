"""docs/sketch_keys.md is that of the table of actions."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "sketch_keys.md"


def test_the_page_on_keys_is_that_of_the_table(update: bool) -> None:
    node = shutil.which("node")
    if node is None:
        pytest.skip("needs Node.js: apt install nodejs")
    script = ROOT / "tests" / "page" / "keys_page.js"
    made = subprocess.run(
        [node, str(script)], capture_output=True, text=True, encoding="utf-8", check=True
    ).stdout
    if update:
        PAGE.write_text(made, encoding="utf-8")
    assert PAGE.read_text(encoding="utf-8") == made, "run pytest --update"
