"""landmark_slam_2d: truth within its sigmas, the optimum of SciPy, and Victoria Park."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from benchmarks import trajectories
from tests.examples.command import solved_by_command
from tests.examples.scripts import printed, script
from tests.public_data import public


@pytest.fixture(scope="module")
def module():
    return script("landmark_slam_2d")


def test_the_truth_is_within_its_sigmas(module) -> None:
    park = module.make_park()
    slam = module.problem(park)
    assert slam.solve().status == "converged"
    covariance = slam.covariance()
    squares = []
    for row, true in zip(slam.landmarks, park.true_landmarks, strict=True):
        wrong = np.asarray(row.pos.value) - true
        squares.append(wrong @ np.linalg.solve(covariance.marginal(row), wrong))
    assert np.median(squares) < 4
    assert np.max(squares) < 25


def test_the_optimum_is_that_of_scipy(module) -> None:
    beside = trajectories.landmark_slam(module, module.make_park(60, 12, seed=3))
    slam = beside.make()
    at_start = beside.residuals(beside.start)
    assert slam.cost() == pytest.approx(at_start @ at_start, rel=1e-9)
    found = beside.by_scipy(ftol=1e-10)
    result = slam.solve(passes="fine", rel_precision=1e-12)
    assert result.end_cost == pytest.approx(2 * found.cost, rel=1e-6)


def test_a_beginning_has_what_was_seen_from_it(module) -> None:
    park = module.make_park(60, 12, seed=3)
    begun = module.beginning(park, 20)
    assert begun.pose.max() < 20
    assert len(begun.turned) == 19
    seen = park.pose < 20
    np.testing.assert_array_equal(begun.ids[begun.landmark], park.ids[park.landmark[seen]])


def test_the_command_line_finds_the_same(module, tmp_path: Path, capsys) -> None:
    slam = module.problem(module.make_park())
    slam.write(tmp_path / "park.npz")
    cost = solved_by_command(module.MODEL, tmp_path / "park.npz", capsys)
    assert cost == pytest.approx(slam.solve().end_cost, rel=1e-9)


def test_report(monkeypatch, capsys) -> None:
    out = printed("landmark_slam_2d", [], monkeypatch, capsys)
    assert "path: RMS 0.830 m; odometry alone 4.639 m" in out


def test_victoria_park(monkeypatch, capsys) -> None:
    path = public("landmark_2d/victoria_park.txt")
    out = printed("landmark_slam_2d", ["--victoria", str(path)], monkeypatch, capsys)
    assert "6969 poses, 151 landmarks, 3640 sights" in out
    cost = re.search(r"-> ([\d.]+)", out)
    assert cost
    # From the odometry alone a solve ends in another valley, at 37 504.
    assert float(cost[1]) == pytest.approx(6137.28, abs=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("part", [150, 600])
def test_the_optimum_of_victoria_park_does_not_depend_on_the_parts(module, part: int) -> None:
    park = module.read_victoria(public("landmark_2d/victoria_park.txt"))
    slam = module.problem(park, *module.start_by_parts(park, part))
    assert slam.solve(rel_precision=1e-10).end_cost == pytest.approx(6137.28, abs=0.05)
