"""camera_imu against the truth, against a spline written independently, and its start."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import BSpline
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

import arael
from tests.compiler.test_look_ups import cumulative_spline
from tests.examples.command import solved_by_command
from tests.examples.scripts import printed, script
from tests.examples.test_problem_pages import blocks, commands


@pytest.fixture(autouse=True)
def interpreted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Kernels are not the point here, and compiling them takes longest."""
    monkeypatch.setattr(arael, "load", partial(arael.load, interpret=True))


@pytest.fixture(scope="module")
def module() -> Any:
    return script("camera_imu")


@pytest.mark.parametrize("seed", [1, 2])
def test_the_truth_is_within_the_covariance(module: Any, seed: int) -> None:
    recording = module.simulate(seed=seed)
    model = module.problem(recording)
    result = model.solve()
    assert result.status == "converged"
    off, covariance = module.errors(model, recording), module.covariance(model)
    assert off @ np.linalg.solve(covariance, off) < chi2.ppf(0.999, 17)
    freedom = 6 * len(recording.t) + 2 * len(recording.times) - 6 * len(model.knots) - 17
    assert chi2.ppf(0.001, freedom) < result.end_cost < chi2.ppf(0.999, freedom)
    sigma = np.sqrt(np.diag(covariance))
    assert sigma[-1] < 1e-4  # the offset
    assert sigma[-2] < 1e-6  # the delay of a line


def test_a_shutter_that_is_not_solved_for_is_seen(module: Any) -> None:
    recording = module.simulate(seconds=6.0, seed=3)
    model = module.problem(recording)
    model.line_delay.fixed = True
    freedom = 6 * len(recording.t) + 2 * len(recording.times) - 6 * len(model.knots) - 16
    assert model.solve().end_cost > 2 * freedom
    model.line_delay.fixed = False
    assert model.solve().end_cost < chi2.ppf(0.999, freedom)
    none = module.simulate(seconds=6.0, seed=3, line_delay=0.0)
    model = module.problem(none)
    model.solve()
    assert abs(float(model.line_delay.value)) < 4e-6


def test_the_start_needs_no_guess(module: Any) -> None:
    recording = module.simulate(seed=4)
    start = module.start(recording)
    # Of lines in the middle of the picture, which the start takes for all.
    assert start.offset == pytest.approx(0.0237 + 240 * 30e-6, abs=0.01)
    assert (recording.mount.inv() * start.mount).magnitude() < 0.05
    assert start.gravity == pytest.approx(recording.truth[3:6], abs=0.5)


def test_the_cost_is_that_of_a_spline_written_independently(module: Any) -> None:
    """Rates of the rotation by differences, the pinhole camera by SciPy's rotations."""
    recording = module.simulate(seconds=2.0, seed=5)
    model = module.problem(recording)
    model.solve()
    offset, line_delay = float(model.offset.value) + 5e-4, float(model.line_delay.value) + 1e-6
    lever = model.lever.value + np.array([1e-3, -2e-3, 1e-3])
    gyro_bias = model.gyro_bias.value + np.array([2e-3, -1e-3, 1e-3])
    acc_bias = model.acc_bias.value + np.array([0.03, -0.02, 0.01])
    model.offset.value, model.line_delay.value = offset, line_delay
    model.lever.value, model.gyro_bias.value, model.acc_bias.value = lever, gyro_bias, acc_bias

    knots, step = module.knot_times(recording), module.STEP
    place = BSpline(knots[0] + step * (np.arange(len(knots) + 4) - 2), model.knots.pos.value, 3)
    turns = Rotation.from_quat(np.roll(np.asarray(model.knots.turn.value), -1, axis=1))

    def turn(times: Any) -> Rotation:
        first = np.minimum(((times - knots[1]) / step).astype(int), len(knots) - 4)
        parts = [
            cumulative_spline(turns[i : i + 4], (t - knots[i + 1]) / step).as_quat()
            for i, t in zip(first, times, strict=True)
        ]
        return Rotation.from_quat(parts)

    R, eps = turn(recording.t), 1e-5
    rate = (turn(recording.t - eps).inv() * turn(recording.t + eps)).as_rotvec() / (2 * eps)
    gravity = np.asarray(model.gravity.value)
    force = R.inv().apply(place(recording.t, 2) - gravity)
    at = recording.times + offset + line_delay * recording.pixel[:, 1]
    p = turn(at).inv().apply(module.target()[recording.corner] - place(at))
    mount = Rotation.from_quat(np.roll(np.asarray(model.mount.value), -1))
    c = mount.inv().apply(p - lever)
    seen = module.FOCAL * c[:, :2] / c[:, 2:] + module.CENTRE
    parts = [
        (rate + gyro_bias - recording.gyro) / module.GYRO_SIGMA,
        (force + acc_bias - recording.acc) / module.ACC_SIGMA,
        (seen - recording.pixel) / module.PIXEL_SIGMA,
    ]
    costs = [(part**2).sum() for part in parts]
    assert min(costs) > 0.02 * max(costs)
    assert model.cost() == pytest.approx(sum(costs), rel=1e-7)


def test_the_page_shows_model_code_and_output(
    module: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any
) -> None:
    texts = {
        "arael": (module.HERE / "camera_imu.arael").read_text(encoding="utf-8"),
        "py": (module.HERE / "camera_imu.py").read_text(encoding="utf-8"),
    }
    for language, text in texts.items():
        assert blocks("camera_imu", language)
        assert [block for block in blocks("camera_imu", language) if block not in text] == []
    monkeypatch.chdir(tmp_path)
    (block,) = blocks("camera_imu", "console")
    (_, lines), _ = commands(block)
    shown = printed("camera_imu", ["--data", "."], monkeypatch, capsys).splitlines()
    assert [line for line in lines if line not in shown] == []
    cost = solved_by_command(module.HERE / "camera_imu.arael", tmp_path / "camera_imu.json", capsys,
                             "--interpret")  # fmt: skip
    assert f"cost {cost:.1f} of" in shown[1]
