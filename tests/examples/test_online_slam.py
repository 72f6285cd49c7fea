"""online_slam: the estimates are those of a batch solve, and the truth is within its sigmas."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import arael
from tests.examples.scripts import printed, script


@pytest.fixture(scope="module")
def module():
    return script("online_slam")


def test_estimates_are_those_of_a_batch_solve(module) -> None:
    drive = module.make_drive(130, seed=1)
    slam = arael.load(module.MODEL)()
    errors = []
    for track in module.follow(slam, drive):
        k = len(track.pos) - 1
        wrong = track.pos[k] - drive.pos[k]
        errors.append(wrong @ np.linalg.solve(track.sigma[k], wrong))
        if k in (60, 129):  # before and after the loop is closed
            batch = slam.copy()
            best = batch.solve(rel_precision=1e-12, abs_precision=0.0).end_cost
            assert slam.cost() == pytest.approx(best, rel=1e-6)
            expected = batch.covariance().marginal(batch.poses[-1])[:2, :2]
            np.testing.assert_allclose(track.sigma[k], expected, rtol=1e-3)
    assert track.full == 0
    assert np.mean(np.array(errors) < 9.21) > 0.95  # 99 % of a chi-square of two
    assert np.linalg.eigvalsh(track.sigma[-1])[-1] < np.linalg.eigvalsh(track.sigma[60])[-1]


def test_a_lag_keeps_the_newest_poses(module) -> None:
    drive = module.make_drive(60, seed=2)
    slam = arael.load(module.MODEL)()
    for track in module.follow(slam, drive, lag=10):  # noqa: B007
        assert len(slam.poses) <= 10
    assert track.full == 0
    seen = {sight.landmark for sight in slam.sights}
    assert len(seen) == len(slam.landmarks)
    assert np.linalg.norm(track.pos[-1] - drive.pos[-1]) < 3


def test_the_script_prints_and_draws(monkeypatch, capsys, tmp_path: Path) -> None:
    path = tmp_path / "map.png"
    text = printed("online_slam", ["--poses", "50", "--plot", str(path)], monkeypatch, capsys)
    assert text.startswith("pose   49: 50 poses,")
    assert path.stat().st_size > 10_000
