"""Recorded problems row by row: `arael replay`."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import arael
from arael.online.recording import Recording
from tests.cli.conftest import Arael
from tests.cli.conftest import arael as arael_command
from tests.online.test_update import robot
from tests.optional import require

command = arael_command  # a fixture

NESTED = """\
struct Sight {
    mark: ref Mark in root.marks
    d: vec2
    constraint seen { mark.p - parent.t - d }
}
struct Pose {
    param t: vec2
    stamp: real
    before: ref Pose in root.poses?
    step: vec2
    sights: list of Sight
    constraint moved when before { t - before.t - step }
    constraint start when not before { t - step }
}
struct Mark { param p: vec2 }
root Walk {
    scale: real
    poses: list of Pose
    marks: list of Mark
}
"""


@pytest.fixture(scope="module")
def walk(tmp_path_factory: pytest.TempPathFactory) -> Any:
    """Poses that are stored from the last to the first, with nested sights of marks."""
    path = tmp_path_factory.mktemp("models") / "walk.arael"
    path.write_text(NESTED, encoding="utf-8")
    model = arael.load(path)(scale=2.0)
    marks = [model.marks.append(p=[k, 1.0]) for k in range(4)]
    rows: dict[int, Any] = {}
    for k in range(5, -1, -1):
        rows[k] = model.poses.append(t=[k, 0.0], stamp=10.0 * k, step=[1.0 if k else 0.0, 0.0])
        for j in (k // 2, (k + 1) // 2):
            rows[k].sights.append(mark=marks[j], d=[j - k + 0.01, 1.0])
    for k in range(1, 6):
        rows[k].before = rows[k - 1]
    return model


def test_rows_come_with_what_they_refer_to(walk: Any) -> None:
    model = type(walk)()
    recording = Recording(walk, "poses.stamp")
    assert recording.steps == 6
    counts = []
    for _ in recording.replay(model):
        counts.append([len(model.poses), len(model.marks)])
        assert model.poses[-1].stamp == 10.0 * (len(counts) - 1)
        model.update()
    assert counts == [[1, 1], [2, 2], [3, 2], [4, 3], [5, 3], [6, 4]]
    assert model.scale == 2.0
    copy = walk.copy()
    best = copy.solve()
    assert model.cost() == pytest.approx(best.end_cost, rel=1e-6, abs=1e-12)
    order = np.argsort(copy.poses.stamp)
    np.testing.assert_allclose(model.poses.t.value, copy.poses.t.value[order], atol=1e-6)


def test_several_rows_a_step() -> None:
    whole, steps = robot("pose_graph_2d", 3, 10)
    list(steps)
    recording = Recording(whole, every=4)
    model = type(whole)()
    assert [len(model.poses) for _ in recording.replay(model)] == [4, 8, 10]
    assert len(model.edges) == len(whole.edges)
    assert model.cost() == pytest.approx(whole.cost(), rel=1e-12)


def test_the_command(command: Arael, tmp_path: Path) -> None:
    require("matplotlib")
    whole, steps = robot("pose_graph_2d", 3, 12)
    list(steps)
    data, picture = tmp_path / "walk.json", tmp_path / "times.png"
    whole.write(data)
    done = command("replay", "pose_graph_2d", str(data), "--plot", str(picture))
    assert done.code == 0, done.err
    assert done.out.startswith("12 steps by poses: mean ")
    assert picture.read_bytes()[1:4] == b"PNG"
    found = json.loads(command("replay", "pose_graph_2d", str(data), "--json").out)
    assert len(found["milliseconds"]) == 12
    assert found["cost"] == pytest.approx(whole.solve().end_cost, rel=1e-3)


def test_what_it_is_replayed_by_must_exist(command: Arael, tmp_path: Path) -> None:
    whole, steps = robot("pose_graph_2d", 3, 3)
    list(steps)
    whole.write(tmp_path / "walk.json")
    done = command("replay", "pose_graph_2d", str(tmp_path / "walk.json"), "--by", "pose")
    assert done.code == 2
    assert "`pose` is neither a collection nor a column of numbers" in done.err
    assert "did you mean `poses`?" in done.err
