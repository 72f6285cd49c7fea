"""imu_preintegration: truth within its sigmas, the optimum of SciPy, the bias to first order."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from arael.geometry import preintegrate, quat_conjugate, quat_exp, quat_log, quat_product
from benchmarks import trajectories
from tests.examples.command import solved_by_command
from tests.examples.scripts import printed, script


@pytest.fixture(scope="module")
def module():
    return script("imu_preintegration")


@pytest.mark.slow
def test_the_truth_is_within_its_sigmas(module) -> None:
    run = module.make_run()
    model = module.problem(run)
    result = model.solve()
    assert result.status == "converged"
    freedom = 15 * 50 + 6 * 51 - 15 * 51 - 3
    assert result.end_cost == pytest.approx(freedom, abs=4 * np.sqrt(2 * freedom))
    covariance = model.covariance()
    wrong = float(model.scale) - module.SCALE
    assert abs(wrong) < 3 * np.sqrt(covariance.marginal("scale").item()) < 0.003
    down = np.arccos(np.asarray(model.down.value) @ run.down)
    assert down**2 < 12 * np.trace(covariance.marginal("down"))
    state = model.states[25]
    nav = state.nav
    errors = [
        np.asarray(nav.pos.value) - run.pos[25],
        quat_log(quat_product(quat_conjugate(run.q[25]), np.asarray(nav.q.value))),
        np.asarray(nav.vel.value) - run.vel[25],
        np.asarray(nav.gyro_bias.value) - run.gyro_bias,
        np.asarray(nav.accel_bias.value) - run.accel_bias,
    ]
    error = np.concatenate(errors)
    square = error @ np.linalg.solve(covariance.marginal(state), error)
    assert 2 < square < 40  # chi-square of 15


@pytest.mark.slow
def test_the_jacobian_is_that_of_differences(module) -> None:
    model = module.problem(module.make_run(2.0))
    model.states.nav.accel_bias = np.array([0.1, -0.2, 0.05])
    problem = model.problem()
    x = np.zeros(problem.size)
    jacobian = problem.jacobian(x)
    dense = jacobian.toarray() if hasattr(jacobian, "toarray") else np.asarray(jacobian)
    for k in range(0, problem.size, 5):
        step = np.zeros(problem.size)
        step[k] = 1e-6
        slope = (problem.residuals(x + step) - problem.residuals(x - step)) / 2e-6
        scale = np.abs(slope).max() + 1
        np.testing.assert_allclose(dense[:, k], slope, atol=2e-5 * scale)


@pytest.mark.slow
def test_the_optimum_is_that_of_scipy(module) -> None:
    beside = trajectories.visual_inertial(module, module.make_run(4.0, seed=3))
    model = beside.make()
    at_start = beside.residuals(beside.start)
    assert model.cost() == pytest.approx(at_start @ at_start, rel=1e-8)
    found = beside.by_scipy(ftol=1e-9)
    result = model.solve(rel_precision=1e-12)
    assert result.end_cost == pytest.approx(2 * found.cost, rel=1e-6)


def test_biases_are_corrected_to_first_order(module) -> None:
    """The error of the correction is quadratic: a quarter at half the bias."""
    run = module.make_run(1.0)
    noise = {"gyro_noise": module.GYRO_NOISE, "accel_noise": module.ACCEL_NOISE}
    base = preintegrate(run.gyro, run.accel, 1 / module.RATE, **noise)
    wrong = []
    for size in (0.02, 0.01):
        dg = size * np.array([1.0, -0.5, 0.7])
        again = preintegrate(run.gyro, run.accel, 1 / module.RATE, gyro_bias=dg, **noise)
        guess = quat_product(base.rotation, quat_exp(base.rotation_by_gyro @ dg))
        turn = quat_log(quat_product(quat_conjugate(guess), again.rotation))
        move = again.position - base.position - base.position_by_gyro @ dg
        wrong.append([np.abs(turn).max(), np.abs(move).max()])
    ratio = np.divide(*wrong)
    assert np.all((ratio > 3.7) & (ratio < 4.3)), ratio


def test_the_command_line_finds_the_same(module, tmp_path: Path, capsys) -> None:
    model = module.problem(module.make_run())
    model.write(tmp_path / "run.npz")
    cost = solved_by_command(module.MODEL, tmp_path / "run.npz", capsys)
    assert cost == pytest.approx(model.solve().end_cost, rel=1e-8)


@pytest.mark.parametrize("line", [
    "51 pictures, 4000 inertial samples",
    "scale 0.4001 +- 0.0003, true 0.4",
    "gravity: 0.032 deg from the truth",
])  # fmt: skip
def test_report(line: str, monkeypatch, capsys) -> None:
    assert line in printed("imu_preintegration", [], monkeypatch, capsys)
