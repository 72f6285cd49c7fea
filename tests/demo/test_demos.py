"""The demos solve their problems as well as they can be solved."""

from __future__ import annotations

import re
import runpy
import sys
from pathlib import Path

import numpy as np
import pytest

from arael.demo import linear, localization, slam
from arael.demo.landmark_table import spread
from arael.demo.scene_run import SolveOptions
from arael.demo.uncertainty import ellipsoid_axes, relative_covariances
from arael.scenes import benchmark_config, columns, demo_config
from tests.cli.conftest import Arael
from tests.optional import needs
from tests.scenes import slam_residuals

QUIET = SolveOptions(verbose=False)
ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def solved() -> slam.SlamRun:
    return slam.run_slam(demo_config(), QUIET)


def test_slam_converges_in_each_pass(solved: slam.SlamRun) -> None:
    assert [p.name for p in solved.result.passes] == ["coarse", "medium", "fine"]
    assert all(p.status == "converged" for p in solved.result.passes)
    assert solved.parameters == 1080


def test_slam_is_near_the_truth(solved: slam.SlamRun) -> None:
    assert solved.errors.pose_rms < 0.02
    assert solved.errors.landmark_relative_median < 0.02
    assert solved.errors.scaled_relative_median < 0.01


@pytest.mark.sweep(5)
@pytest.mark.parametrize("seed", range(1, 21))
def test_slam_on_other_seeds(seed: int) -> None:
    run = slam.run_slam(demo_config(seed=seed), QUIET)
    assert all(p.status == "converged" for p in run.result.passes)
    assert run.errors.pose_rms < 0.02
    assert run.errors.scaled_relative_median < 0.01
    assert np.median(run.local_errors / run.errors.distance) < 0.025
    assert (run.jacobian.residuals**2).max() < 25


@pytest.mark.slow
def test_landmarks_are_near_the_truth_on_most_seeds() -> None:
    """The map's scale has a posterior sigma near 1 %: see docs/internals/scenes.md."""
    found = np.array(
        [
            slam.run_slam(demo_config(seed=k), QUIET).errors.landmark_relative_median
            for k in range(40)
        ]
    )
    assert np.mean(found < 0.02) > 0.9
    assert found.max() < 0.03


@pytest.mark.slow
def test_scale_error_is_what_its_uncertainty_says() -> None:
    """The scale is the least determined direction: its error is a sample of the posterior."""
    ratios = []
    for seed in range(1, 9):
        run = slam.run_slam(demo_config(seed=seed), QUIET)
        centred = run.scene.pos - run.scene.pos.mean(axis=0)
        weight = np.zeros((len(centred), 6))
        weight[:, :3] = centred / np.sum(centred**2)
        direction = np.concatenate([weight.ravel(), np.zeros(3 * len(run.landmarks))])
        variance = 2 * direction @ np.linalg.solve(run.hessian, direction)
        ratios.append((1 / run.errors.scale - 1) / np.sqrt(variance))
    assert 0.5 < np.sqrt(np.mean(np.square(ratios))) < 2.0


def test_the_compiled_cost_is_that_of_independent_residuals(solved: slam.SlamRun) -> None:
    scene, instance = solved.scene, solved.instance
    cols = columns(scene)
    ea = np.asarray(instance.poses.ea.value)
    expected = {
        "PointFrine.bearing": slam_residuals.bearing(cols, solved.poses, ea, solved.landmarks),
        "Pose.gps": slam_residuals.gps(cols, solved.poses),
        "Pose.tilt": slam_residuals.tilt(cols, ea),
        "PosePair.odometry": slam_residuals.odometry(cols, solved.poses, ea),
    }
    table = instance.cost_table()
    for label, residuals in expected.items():
        assert table[label] == pytest.approx(np.sum(residuals**2), rel=1e-9), label


def test_wrong_associations_are_let_go(solved: slam.SlamRun) -> None:
    costs = solved.bearing_costs.max(axis=1)
    wrong = solved.scene.observations.wrong
    assert solved.bearing_costs.max() < 25
    assert np.median(costs[wrong]) > 15
    assert np.median(costs[~wrong]) < 1


@pytest.mark.parametrize("trajectory", ["loop", "eight"])
def test_closed_paths(trajectory: str) -> None:
    run = slam.run_slam(demo_config(trajectory=trajectory), QUIET)  # type: ignore[arg-type]
    assert all(p.status == "converged" for p in run.result.passes)
    assert run.errors.pose_rms < 0.02


def test_right_associations_are_solved_to_millimetres() -> None:
    run = slam.run_slam(benchmark_config(40), QUIET)
    assert run.errors.pose_rms < 0.006


def test_report_prints_what_the_reference_prints(solved: slam.SlamRun) -> None:
    text = "\n".join(slam.report(solved))
    lines = re.findall(
        r"LM \d+: \|d\|=\d+\.\d{3}m rel=\d+\.\d\d% dist=\d+\.\dm "
        r"sigma=\(\d+\.\d{3},\d+\.\d{3},\d+\.\d{3}\)m frines=\d+",
        text,
    )
    assert len(lines) == slam.SHOWN
    assert "scene: s-curve, 60 poses, 240 landmarks, 5206 observations, seed 42" in text
    assert "pass fine: converged" in text


def test_uncertainty_agrees_with_the_covariance(solved: slam.SlamRun) -> None:
    covariance = solved.instance.covariance()
    for k in (0, 100, 239):
        pose = solved.instance.poses[int(solved.errors.closest[k])]
        expected = covariance.relative(solved.instance.landmarks[k], pose)
        assert solved.covariances[k] == pytest.approx(expected, rel=1e-5, abs=1e-9)


def test_relative_covariance_of_a_chain() -> None:
    """l measured from p with sigma 0.2, p from the origin with sigma 3: relative, 0.2 is left."""
    one, two = 2 / 3.0**2, 2 / 0.2**2
    hessian = np.block(
        [[(one + two) * np.eye(3), -two * np.eye(3)], [-two * np.eye(3), two * np.eye(3)]]
    )
    found = relative_covariances(hessian, np.array([3]), np.array([0]))
    assert found[0] == pytest.approx(0.04 * np.eye(3), abs=1e-12)
    assert ellipsoid_axes(found)[0] == pytest.approx([0.2, 0.2, 0.2])


def test_axes_descend() -> None:
    axes = ellipsoid_axes(np.diag([1.0, 9.0, 4.0])[None])
    assert axes[0] == pytest.approx([3, 2, 1])


def test_spread_covers_best_and_worst() -> None:
    relative = np.array([0.5, 0.1, 0.9, 0.3, 0.7])
    assert spread(relative, 3).tolist() == [1, 0, 2]
    assert spread(relative, 9).tolist() == [1, 3, 0, 4, 2]


def test_localization() -> None:
    run = localization.run_localization(demo_config(), QUIET)
    assert all(p.status == "converged" for p in run.result.passes)
    assert run.pose_rms < 0.015
    assert run.half_bandwidth == 11
    assert run.parameters == 360
    assert (run.poses - run.scene.pos).std(axis=0) == pytest.approx(
        np.median(run.sigma, axis=0), rel=0.7
    )


def test_localization_by_the_band_solver() -> None:
    run = localization.run_localization(demo_config(30), SolveOptions(solver="band", verbose=False))
    other = localization.run_localization(
        demo_config(30), SolveOptions(solver="dense", verbose=False)
    )
    assert run.result.plan["solver"] == "band"
    assert run.result.end_cost == pytest.approx(other.result.end_cost, rel=1e-9)


def test_linear() -> None:
    run = linear.run_linear(options=QUIET)
    least_squares, robust = (linear.summary(run)[k] for k in ("least_squares_rms", "robust_rms"))
    assert robust < 0.003
    assert least_squares > 0.1
    assert run.robust == pytest.approx((0.7, 1.0), abs=0.01)


def test_demo_json(arael: Arael) -> None:
    found = arael("demo", "slam", "--poses", "20", "--json").json
    for key in ("status", "passes", "plan", "timing", "pose_rms", "landmark_relative_median"):
        assert key in found
    assert found["observations"] > 0
    assert arael("demo", "localization", "--poses", "20", "--json").json["half_bandwidth"] == 11
    assert arael("demo", "linear", "--json").json["observations"] == 100


@needs("matplotlib")
def test_demo_pictures(arael: Arael, tmp_path: Path) -> None:
    for name in ("slam", "localization"):
        done = arael("demo", name, "-q", "--poses", "20", "--plot", tmp_path / f"{name}.png")
        assert done.code == 0
        assert (tmp_path / f"{name}.png").stat().st_size > 10_000
        assert (tmp_path / f"{name}-hessian.png").stat().st_size > 1000
    assert arael("demo", "linear", "-q", "--plot", tmp_path / "line.png").code == 0
    assert (tmp_path / "line.png").stat().st_size > 10_000


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("slam", "--poses", "1"), "1 is not in the range"),
        (("slam", "--trajectory", "circle"), "'circle' is not one of"),
        (("slam", "--plot", "x.bmp"), "E0861"),
        (("linear", "--plot", "no/such/x.png"), "E0853"),
        (("orbit",), "orbit"),
    ],
)
def test_wrong_options(arael: Arael, arguments: tuple[str, ...], told: str) -> None:
    done = arael("demo", *arguments)
    assert done.code == 2
    assert told in done.err


@pytest.mark.parametrize(
    ("folder", "script", "model"),
    [
        ("slam_demo", "slam_demo.py", "slam"),
        ("loc_demo", "loc_demo.py", "localization"),
        ("linear_demo", "linear_demo.py", "linear"),
    ],
)
def test_examples_run_and_have_the_standard_model(
    folder: str,
    script: str,
    model: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    here = ROOT / "examples" / folder
    assert (here / f"{model}.arael").read_text() == (ROOT / "models" / f"{model}.arael").read_text()
    monkeypatch.setattr(sys, "argv", [script])
    runpy.run_path(str(here / script), run_name="__main__")
    assert "42" in capsys.readouterr().out
