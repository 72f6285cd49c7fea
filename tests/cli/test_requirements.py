"""What must hold exactly, on the command line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.cli.conftest import Arael

MODEL = """root Point {
    param x: vec2 [m]
    goal: vec2 [m]
    constraint near { (x - goal) / (1 [m]) }
    require circle { norm(x) == 2 [m] }
    require right { x.x >= LEAST }
}
"""


@pytest.mark.parametrize(
    "least, status, code", [("0 [m]", "converged", 0), ("3 [m]", "infeasible", 1)]
)
def test_info_and_solve(arael: Arael, tmp_path: Path, least: str, status: str, code: int) -> None:
    model, data = tmp_path / "point.arael", tmp_path / "point.json"
    model.write_text(MODEL.replace("LEAST", least))
    data.write_text(json.dumps({"x": [1, 0.1], "goal": [3, 4]}))
    assert "2 rows of an instance of each" in arael("info", str(model)).out
    assert arael("info", str(model), "--json").json["constraints"][1]["require"] == "equal"
    done = arael("solve", str(model), str(data), "--json")
    assert done.code == code
    assert f'"status": "{status}"' in done.out
    shown = arael("solve", str(model), str(data)).out
    assert "Point.circle" in shown
    report = tmp_path / "point.html"
    arael("solve", str(model), str(data), "--report", str(report))
    assert "What holds exactly" in report.read_text(encoding="utf-8")
