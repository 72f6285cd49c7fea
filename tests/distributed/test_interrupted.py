"""A command that is broken off or killed, and the run that goes on from it."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.optional import needs

pytestmark = [needs("Dask"), pytest.mark.slow]

MODEL = "root One : f64 { param a: real; target: real\n constraint near { a - target } }"


@pytest.fixture
def place(tmp_path: Path) -> Path:
    """A model and six problems, the last of which blocks its worker."""
    (tmp_path / "m.arael").write_text(MODEL)
    (tmp_path / "logs").mkdir()
    for k in range(5):
        (tmp_path / "logs" / f"p{k}.json").write_text(json.dumps({"a": 0, "target": k}))
    os.mkfifo(tmp_path / "logs" / "p5.json")
    return tmp_path


def start(place: Path, *more: str) -> subprocess.Popen[str]:
    args = ["solve", "m.arael", "logs/*.json", "--workers", "2", "--interpret", "-o", "out"]
    return subprocess.Popen(
        [sys.executable, "-m", "arael", *args, *more],
        cwd=place,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


def rows(place: Path) -> dict[str, int]:
    """Rows that were written, with their times."""
    folder = place / "out" / "rows"
    return {path.name[:2]: path.stat().st_mtime_ns for path in folder.glob("p*.json")}


def wait_for_rows(place: Path, process: subprocess.Popen[str]) -> dict[str, int]:
    until = time.monotonic() + 100
    while len(rows(place)) < 5:
        assert time.monotonic() < until and process.poll() is None
        time.sleep(0.05)
    return rows(place)


def resume(place: Path, before: dict[str, int]) -> None:
    """Solve what is missing; nothing is solved twice."""
    (place / "logs" / "p5.json").unlink()
    (place / "logs" / "p5.json").write_text('{"a": 0, "target": 5}')
    again = start(place, "--resume")
    out, err = again.communicate(timeout=100)
    assert again.returncode == 0, err
    assert "6 of 6 problems converged" in out
    after = rows(place)
    assert {name: after[name] for name in before} == before
    assert len(after) == 6
    for k in range(6):
        found = json.loads((place / "out" / f"p{k}.json").read_text())
        assert found["a"] == pytest.approx(k)
    assert len(list((place / "out").glob("table.*"))) == 1
    assert not list((place / "out").rglob("*.tmp"))


def group_is_empty(group: int) -> bool:
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return True
    return False


def test_a_run_goes_on_after_its_client_was_killed(place: Path) -> None:
    process = start(place)
    before = wait_for_rows(place, process)
    process.kill()
    process.communicate(timeout=100)
    until = time.monotonic() + 60
    while not group_is_empty(process.pid):  # workers notice that it is gone
        assert time.monotonic() < until, "worker processes were left over"
        time.sleep(0.1)
    resume(place, before)


def test_ctrl_c_keeps_what_has_ended(place: Path) -> None:
    process = start(place)
    before = wait_for_rows(place, process)
    time.sleep(0.5)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does
    out, err = process.communicate(timeout=100)
    assert process.returncode == 1, err
    assert "5 of 6 problems converged" in out
    assert "interrupted: what had ended is kept; --resume solves the rest" in err
    assert "Traceback" not in err
    assert list((place / "out").glob("table.*"))
    resume(place, before)
