"""The calculator's session: what it shows, and that `arael calc` gives the same."""

from __future__ import annotations

import importlib.util
import math
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest

from tests.optional import needs

FOLDER = Path(__file__).parents[2] / "examples" / "calc_demo"


@pytest.fixture(scope="module")
def demo() -> ModuleType:
    spec = importlib.util.spec_from_file_location("calc_demo", FOLDER / "calc_demo.py")
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@needs("matplotlib")
def test_it_runs(
    demo: ModuleType,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    picture = tmp_path / "calc_demo.png"
    monkeypatch.setattr(sys, "argv", ["calc_demo.py", "--plot", str(picture)])
    demo.main()
    shown = capsys.readouterr().out
    answers = [line for line in shown.splitlines() if not line.startswith(">")]
    assert float(answers[0]) == pytest.approx(1 + 2 * math.sin(math.pi / 6))
    assert answers[1:4] == ["10", "6 * y", str(2**2 + 10 * 3)]
    assert "2 * t + 10" in answers
    assert repr(0.1 - 0.1**3 / 6)[:16] in shown
    assert "u^3 + 3 * u^2 + 3 * u + 1" in answers
    assert "error[E0120]" in shown
    assert picture.stat().st_size > 5000


def test_the_command_gives_the_same(demo: ModuleType) -> None:
    session = (FOLDER / "session.calc").read_text(encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-m", "arael", "calc"],
        input=session,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert done.returncode == 2  # one line of it is wrong
    shown = [line for line in demo.transcript(session.splitlines()) if not line.startswith(">")]
    for line in done.stdout.splitlines():
        assert line in shown
    assert len(done.stdout.splitlines()) == 10
