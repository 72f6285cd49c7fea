"""The example refs_demo against linear least squares on what is left in the window."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.examples.scripts import script
from tests.optional import needs


def test_the_window_is_solved_as_it_stands() -> None:
    drive = script("refs_demo").Drive()
    window = drive.window
    for _ in range(9):
        drive.advance()
    window.landmarks.remove(drive.landmarks[0])
    poses, landmarks = len(window.poses), len(window.landmarks)
    assert (poses, landmarks) == (6, 2)

    rows, right = [], []

    def row(entries: dict[int, float], value: float, isigma: float) -> None:
        one = np.zeros(poses + landmarks)
        for column, entry in entries.items():
            one[column] = entry
        rows.append(isigma * one)
        right.append(isigma * value)

    for pose in window.poses:
        row({pose.row: 1}, pose.prior, 0.5)
    for step in window.steps:
        row({step["from"].row: -1, step.to.row: 1}, step.length, 20)
    for landmark in window.landmarks:
        for seen in landmark.sightings:
            row({poses + landmark.row: 1, seen.pose.row: -1}, seen.distance, 10)
    assert len(rows) > poses + landmarks + 5
    expected, (cost,), *_ = np.linalg.lstsq(np.array(rows), np.array(right), rcond=None)

    import arael

    result = window.solve(config=arael.LmConfig(initial_lambda=1e-9, rel_precision=1e-12))
    assert result.status == "converged"
    found = np.concatenate([window.poses.x.value, window.landmarks.x.value])
    np.testing.assert_allclose(found, expected, atol=1e-7)
    assert window.cost() == pytest.approx(cost)


def test_handles_stay_good_and_stale_ones_say_so() -> None:
    drive = script("refs_demo").Drive()
    handles = [drive.advance() for _ in range(8)]
    assert [h.is_valid for h in handles] == [False] * 2 + [True] * 6
    assert [h.row for h in handles[2:]] == list(range(6))
    assert drive.window.steps["from"].is_valid.all()
    assert len(drive.window.steps) == 5


@needs("matplotlib")
def test_what_it_prints(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    script("refs_demo").main(["--plot", str(tmp_path / "out.png")])
    printed = capsys.readouterr().out
    assert "reading through it: E0709" in printed
    assert "the second is now poses[0]" in printed
    assert "the newest pose: True" in printed
    assert (tmp_path / "out.png").stat().st_size > 5000
