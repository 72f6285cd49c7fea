"""Many problems, started as users start them: a command, a script."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from tests.optional import needs

pytestmark = needs("Dask")

SCRIPT = """
import arael
from arael.distributed import map

Line = arael.load("linear", interpret=True)
for future in map(Line, ["data/*.json"], workers=1):
    print(future.result().status)
"""


COMMAND = """
import sys
from arael.cli.main import main
if __name__ == "__main__":
    sys.exit(main())
"""
"""The console script as installers write it. Worker processes import it."""


@pytest.fixture
def data(tmp_path: Path) -> Path:
    folder = tmp_path / "data"
    folder.mkdir()
    for k in (1, 2, 3):
        points = [{"x": x, "y": k * x + 1} for x in range(4)]
        (folder / f"{k}.json").write_text(json.dumps({"a": 0, "b": 0, "data": points}))
    return folder


def test_the_console_script_solves_with_shipped_kernels_on_two_workers(data: Path) -> None:
    command = data.parent / "arael"
    command.write_text(COMMAND)
    args = ["solve", "linear", "data/*.json", "--workers", "2", "-o", "out"]
    done = subprocess.run(
        [sys.executable, command, *args],
        cwd=data.parent,
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    assert "3 of 3 problems converged" in done.stdout
    for k in (1, 2, 3):
        found = json.loads((data.parent / "out" / f"{k}.json").read_text())
        assert (found["a"], found["b"]) == (pytest.approx(k, abs=1e-4), pytest.approx(1, abs=1e-4))
        row = json.loads((data.parent / "out" / "rows" / f"{k}.json.json").read_text())
        assert row["kernels"] == "shipped", row["interpreted"]


def test_a_script_without_a_guard_is_explained(data: Path) -> None:
    (data.parent / "script.py").write_text(SCRIPT)
    done = subprocess.run(
        [sys.executable, "script.py"], cwd=data.parent, capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 1
    assert "E0887" in done.stderr
    assert 'if __name__ == "__main__":' in done.stderr
    assert done.stderr.count("Traceback") <= 1  # the script's own; none of the workers
