"""The standard model `sketch` as a model for `arael solve`."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.cli.conftest import Arael


def test_a_sketch_is_solved_as_an_ordinary_model(
    arael: Arael, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A rectangle 4 x 3 with a circle in its middle that touches the upper side."""
    monkeypatch.chdir(tmp_path)
    points = [[0.1, 0], [3.8, 0.3], [4.2, 2.7], [-0.2, 3.1], [2, 1.2]]
    data = {
        "points": [{"pos": one} for one in points],
        "scalars": [{"value": 0.8}],
        "locks": [{"p": 0, "at": [0, 0]}],
        "horizontals": [{"a": 0, "b": 1}],
        "perpendiculars": [{"a": 0, "b": 1, "c": 1, "d": 2}, {"a": 0, "b": 1, "c": 0, "d": 3}],
        "parallels": [{"a": 0, "b": 1, "c": 3, "d": 2}],
        "distances": [{"a": 0, "b": 1, "value": 4}, {"a": 0, "b": 3, "value": 3}],
        "midpoints": [{"m": 4, "a": 0, "b": 2}],
        "tangent_line_circles": [{"a": 3, "b": 2, "center": 4, "r": 0, "side": -1}],
    }
    (tmp_path / "in.json").write_text(json.dumps(data))
    done = arael("solve", "sketch", "in.json", "-o", "out.json", "--interpret")
    assert done.code == 0, done.err
    solved = json.loads((tmp_path / "out.json").read_text())
    found = [one["pos"] for one in solved["points"]]
    expected = [[0, 0], [4, 0], [4, 3], [0, 3], [2, 1.5]]
    assert found == [pytest.approx(one, abs=1e-8) for one in expected]
    assert solved["scalars"][0]["value"] == pytest.approx(1.5)
