from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from arael.cli.main import run


@dataclass(frozen=True)
class Outcome:
    """What a run of the command left: exit code, standard output, standard error."""

    code: int
    out: str
    err: str

    @property
    def json(self) -> Any:
        return json.loads(self.out)


Arael = Callable[..., Outcome]


@pytest.fixture
def arael(capsys: pytest.CaptureFixture[str]) -> Arael:
    """Run the command in this process."""

    def call(*args: str | Path) -> Outcome:
        capsys.readouterr()
        code = run([str(a) for a in args])
        captured = capsys.readouterr()
        return Outcome(int(code), captured.out, captured.err)

    return call


MODEL = """\
# A line.
struct Point { x: real; y: real }

root Line : f64 {
    param a: real
    param b: real
    points: list of Point
    sigma:  real = 1.0
    origin: vec2 = [0.0, 0.0]

    fit points as p {
        (a * p.x + b - p.y) / sigma
    }

    solve {
        pass rough { sigma = 10.0 }
        pass fine  { sigma = 1.0   rel_precision = 1e-9 }
    }
}
"""

DATA = """{"a": 0.0, "b": 0.0, "points": [
    {"x": 0, "y": 1}, {"x": 1, "y": 3}, {"x": 2, "y": 5}]}"""


@pytest.fixture
def line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder, made the current one, with `line.arael` and `line.json`: solution a = 2, b = 1."""
    (tmp_path / "line.arael").write_text(MODEL)
    (tmp_path / "line.json").write_text(DATA)
    monkeypatch.chdir(tmp_path)
    return tmp_path
