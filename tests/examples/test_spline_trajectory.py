"""spline_trajectory: truth within its sigmas, the optimum of SciPy. On the expression machine."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm, logm
from scipy.spatial.transform import Rotation

from benchmarks import trajectories
from tests.examples.command import solved_by_command
from tests.examples.scripts import script


@pytest.fixture(scope="module")
def module():
    return script("spline_trajectory")


@pytest.fixture(scope="module")
def solved(module):
    flight = module.make_flight()
    model = module.problem(flight, interpret=True)
    return flight, model, model.solve()


@pytest.mark.slow
def test_the_truth_is_within_its_sigmas(module, solved) -> None:
    flight, model, result = solved
    assert result.status == "converged"
    freedom = 3 * 350 - 6 * 23
    assert result.end_cost == pytest.approx(freedom, abs=4 * np.sqrt(2 * freedom))
    turns, pos = module.solved_knots(model)
    back = flight.true_turns.inv()
    wrong = module.logarithm(back * turns, back.apply(pos - flight.true_pos))
    covariance = model.covariance()
    squares = [
        wrong[k] @ np.linalg.solve(covariance.marginal(model.knots[k]), wrong[k])
        for k in range(2, 21)
    ]
    assert 3 < np.mean(squares) < 9  # chi-square of 6
    assert np.max(squares) < 30


def test_report(module, solved) -> None:
    flight, model, result = solved
    text = "\n".join(module.report(model, flight, result))
    assert "23 knots, 200 positions, 150 attitudes" in text
    assert "RMS of positions 19.7 mm, measured to 52.0 mm" in text


def test_the_optimum_is_that_of_scipy(module, solved) -> None:
    flight, _, result = solved
    model = module.problem(flight, interpret=True)
    beside = trajectories.spline(module, flight, lambda: None)
    at_start = beside.residuals(beside.start)
    assert model.cost() == pytest.approx(at_start @ at_start, rel=1e-8)
    found = beside.by_scipy()
    assert result.end_cost == pytest.approx(2 * found.cost, rel=1e-6)


def test_the_command_line_finds_the_same(module, solved, tmp_path: Path, capsys) -> None:
    flight, _, result = solved
    module.problem(flight, interpret=True).write(tmp_path / "spline.npz")
    cost = solved_by_command(module.MODEL, tmp_path / "spline.npz", capsys, "--interpret")
    assert cost == pytest.approx(result.end_cost, rel=1e-9)


def test_the_spline_is_that_of_matrix_exponentials(module) -> None:
    """``T0 exp(B1 log(T0^-1 T1)) exp(B2 log(T1^-1 T2)) exp(B3 log(T2^-1 T3))`` by SciPy."""
    rng = np.random.default_rng(3)
    turns = Rotation.from_rotvec(rng.normal(0, 0.4, (4, 3)))
    pos = rng.normal(0, 1, (4, 3))
    T = np.tile(np.eye(4), (4, 1, 1))
    T[:, :3, :3], T[:, :3, 3] = turns.as_matrix(), pos
    u = 0.37
    expected = T[0]
    weights = (5 + 3 * u - 3 * u**2 + u**3, 1 + 3 * u + 3 * u**2 - 2 * u**3, u**3)
    for j, weight in enumerate(weights):
        expected = expected @ expm(weight / 6 * logm(np.linalg.inv(T[j]) @ T[j + 1]).real)
    turn, at = module.evaluate(turns, pos, np.array([0]), np.array([u]))
    np.testing.assert_allclose(turn.as_matrix()[0], expected[:3, :3], atol=1e-9)
    np.testing.assert_allclose(at[0], expected[:3, 3], atol=1e-9)
