"""Names of files that are no text, in a terminal that takes UTF-8 alone."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.cli.conftest import MODEL


@pytest.mark.sweep(2)
@pytest.mark.parametrize(("text", "code"), [('{"a": 1, "b": 2}', 0), ('{"c": 1}', 2)])
def test_check_prints_them(tmp_path: Path, text: str, code: int) -> None:
    if sys.platform in ("win32", "darwin"):
        pytest.skip("this system's file names are text; run on Linux")
    data = os.fsdecode(os.fsencode(tmp_path) + b"/d\xff.json")
    with open(data, "w") as file:
        file.write(text)
    (tmp_path / "line.arael").write_text(MODEL)
    done = subprocess.run(
        [sys.executable, "-m", "arael", "check", str(tmp_path / "line.arael"), data],
        env={**os.environ, "PYTHONIOENCODING": "utf-8:strict", "PYTHONUTF8": "1"},
        capture_output=True,
        check=False,
    )
    said = (done.stdout + done.stderr).decode()
    assert done.returncode == code, said
    assert "internal error" not in said
    assert "ff.json" in said
