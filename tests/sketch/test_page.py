"""The page of the sketch editor: its tests by node, its size, what it loads."""

from __future__ import annotations

import gzip
import re
import subprocess
from pathlib import Path

import arael.sketch
from tests import optional

PAGE = Path(arael.sketch.__file__).parent / "page"
TESTS = Path(__file__).parents[1] / "page"
DEVELOPMENT = ("package.json", "package-lock.json", "tsconfig.json", "eslint.config.js")
MOST_BYTES = 300_000


def shipped() -> list[Path]:
    """Files that a browser loads."""
    files = [file for file in PAGE.rglob("*") if file.is_file()]
    return [f for f in files if f.name not in DEVELOPMENT and "node_modules" not in f.parts]


def test_the_unit_tests_of_the_page_pass() -> None:
    node = optional.program("node")
    tests = sorted(map(str, TESTS.glob("*.test.js")))
    done = subprocess.run([node, "--test", *tests], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stdout[-6000:] + done.stderr[-2000:]


def test_the_page_is_small() -> None:
    """Compressed: half of the source is comments with types."""
    total = sum(len(gzip.compress(file.read_bytes())) for file in shipped())
    assert total < MOST_BYTES


def test_the_page_loads_nothing_from_elsewhere() -> None:
    for file in shipped():
        if file.suffix in (".js", ".css", ".html"):
            text = file.read_text(encoding="utf-8").replace("http://www.w3.org/", "")
            assert not re.search(r"(src|href|import|url|from)[ =(]*[\"']?(https?:)?//\w", text), (
                file
            )


def test_files_of_the_page_are_short() -> None:
    for file in shipped():
        if file.suffix == ".js":
            assert len(file.read_text(encoding="utf-8").splitlines()) <= 300, file
