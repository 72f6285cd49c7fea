"""range_slam: truth within its sigmas, the optimum of SciPy, and the public set Plaza1."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks import trajectories
from tests.examples.command import solved_by_command
from tests.examples.scripts import printed, script
from tests.public_data import public


@pytest.fixture(scope="module")
def module():
    return script("range_slam")


def test_the_truth_is_within_its_sigmas(module) -> None:
    field = module.make_field()
    slam = module.problem(field)
    assert slam.solve().status == "converged"
    covariance = slam.covariance()
    errors = [(float(slam.scale) - module.SCALE) / np.sqrt(covariance.marginal("scale").item())]
    for row, true in zip(slam.beacons, field.true_beacons, strict=True):
        wrong = np.asarray(row.pos.value) - true
        errors.append(np.sqrt(wrong @ np.linalg.solve(covariance.marginal(row), wrong)))
    assert np.abs(errors).max() < 3.5
    assert np.linalg.norm(np.asarray(slam.beacons.pos.value) - field.true_beacons, axis=1).max() < 1


def test_the_optimum_is_that_of_scipy(module) -> None:
    field = module.make_field(60, seed=3)
    beside = trajectories.range_slam(module, field)
    slam = beside.make()
    at_start = beside.residuals(beside.start)
    assert slam.cost() == pytest.approx(at_start @ at_start, rel=1e-9)
    found = beside._replace(exact=True).by_scipy(ftol=1e-10)
    result = slam.solve(rel_precision=1e-12)
    assert result.end_cost == pytest.approx(2 * found.cost, rel=1e-6)


def test_beacons_are_placed_from_exact_ranges(module) -> None:
    points = np.random.default_rng(1).uniform(-20, 20, (30, 2))
    ranges = 1.07 * np.linalg.norm(points - [40, -7], axis=1)
    ranges[:3] += 9  # wild ones
    place, scale = module.multilaterate(points, ranges)
    np.testing.assert_allclose(place, [40, -7], atol=0.1)
    assert scale == pytest.approx(1.07, abs=2e-3)


def test_points_on_a_line_are_refused(module) -> None:
    points = np.column_stack([np.linspace(0, 10, 20), np.zeros(20)])
    with pytest.raises(ValueError, match="the points lie on a line"):
        module.multilaterate(points, np.linalg.norm(points - [3, 4], axis=1))


def test_the_command_line_finds_the_same(module, tmp_path: Path, capsys) -> None:
    slam = module.problem(module.make_field())
    slam.write(tmp_path / "field.npz")
    cost = solved_by_command(module.MODEL, tmp_path / "field.npz", capsys)
    assert cost == pytest.approx(slam.solve().end_cost, rel=1e-9)


def test_report(monkeypatch, capsys) -> None:
    out = printed("range_slam", [], monkeypatch, capsys)
    assert "path: RMS 0.129 m; odometry alone 1.282 m" in out


def test_plaza(monkeypatch, capsys) -> None:
    folder = public("range_slam/Plaza1_.mat").parent
    out = printed("range_slam", ["--plaza", str(folder)], monkeypatch, capsys)
    assert "3529 poses, 3529 ranges to 4 beacons" in out
    assert "path: RMS 0.212 m; odometry alone 1.469 m" in out
    assert "beacons: 0.17 0.24 0.20 0.21 m" in out
