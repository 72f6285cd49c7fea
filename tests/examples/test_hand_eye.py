"""hand_eye against the truth, against SciPy, on the command line."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

import arael
from arael.cli.main import run
from benchmarks.by_scipy import hand_eye as by_scipy
from tests.examples.scripts import EXAMPLES, printed, script


@pytest.fixture(autouse=True)
def interpreted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Kernels are not the point here, and compiling them takes longest."""
    monkeypatch.setattr(arael, "load", partial(arael.load, interpret=True))


def test_robot_world_start_and_optimum_are_those_of_scipy() -> None:
    module = script("hand_eye")
    poses = module.simulate(shots=12, seed=3)
    model = module.robot_world(poses)
    start = by_scipy.residuals(np.zeros(12), poses, module.SIGMA)
    assert model.cost() == pytest.approx(start @ start, rel=1e-9)
    result = model.solve(rel_precision=1e-9)
    assert result.end_cost == pytest.approx(2 * by_scipy.solve(poses).cost, rel=1e-6)


def test_hand_eye_optimum_is_that_of_scipy() -> None:
    module = script("hand_eye")
    poses = module.simulate(shots=16, seed=4)
    a, b, whiten = module.motions(poses)
    a_turn, b_turn = (Rotation.from_matrix(p[:, :3, :3]) for p in (a, b))

    def residuals(x: np.ndarray) -> np.ndarray:
        turn = Rotation.from_rotvec(x[:3])
        left = a_turn * turn
        off = turn.apply(b[:, :3, 3]) + x[3:] - a_turn.apply(x[3:]) - a[:, :3, 3]
        found = by_scipy.log(left.inv() * turn * b_turn, left.inv().apply(off))
        return np.einsum("nij,nj->ni", whiten, found).ravel()

    model = module.hand_eye(poses)
    start = residuals(np.zeros(6))
    assert model.cost() == pytest.approx(start @ start, rel=1e-9)
    result = model.solve(rel_precision=1e-9)
    best = least_squares(residuals, np.zeros(6), x_scale="jac")
    assert result.end_cost == pytest.approx(2 * best.cost, rel=1e-6)


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("form", ["hand_eye", "robot_world"])
def test_the_truth_is_within_the_covariance(form: str, seed: int) -> None:
    module = script("hand_eye")
    poses = module.simulate(seed=seed)
    model = getattr(module, form)(poses)
    result = model.solve(rel_precision=1e-9)
    unknown = {"X": poses.x} if form == "hand_eye" else {"X": poses.x, "Y": poses.y}
    off = np.concatenate([
        module.error(getattr(model, name).matrix, true) for name, true in unknown.items()
    ])  # fmt: skip
    covariance = model.covariance().marginal(list(unknown))
    assert off @ np.linalg.solve(covariance, off) < chi2.ppf(0.999, len(off))
    freedom = model.jacobian().shape[0] - len(off)
    assert chi2.ppf(0.001, freedom) < result.end_cost < chi2.ppf(0.999, freedom)


def test_turns_about_one_axis_leave_two_directions_free() -> None:
    module = script("hand_eye")
    poses = module.simulate(shots=8)
    turn = np.linspace(0, 1, 8)[:, None] * [0, 0, 1.0]
    a = module.rigid(np.zeros((8, 3)), turn)
    model = module.robot_world(
        module.Poses(a, np.linalg.inv(poses.y) @ a @ poses.x, poses.x, poses.y)
    )
    model.X, model.Y = (
        [*t[:3, 3], *module.quat_from_matrix(t[:3, :3])] for t in (poses.x, poses.y)
    )
    free = model.free_directions()
    assert len(free) == 2
    assert [str(one) for one in free] == [
        "`X`, `Y` move together along z",
        "`X`, `Y` turn together about z",
    ]


@pytest.mark.parametrize("seed", [1, 2])
def test_a_hand_in_motion_finds_the_offset_of_the_clocks(seed: int) -> None:
    module = script("hand_eye")
    poses = module.sweep(seconds=12.0, seed=seed)
    model = module.moving(poses)
    start = float(model.offset.value)
    result = model.solve(rel_precision=1e-9)
    assert abs(start - poses.offset) < 0.01
    off = [module.error(getattr(model, n).matrix, t) for n, t in (("X", poses.x), ("Y", poses.y))]
    off = np.array([*off[0], *off[1], poses.offset - float(model.offset.value)])
    covariance = model.covariance().marginal(["X", "Y", "offset"])
    assert off @ np.linalg.solve(covariance, off) < chi2.ppf(0.999, 13)
    freedom = 6 * len(poses.shot) - 13
    assert chi2.ppf(0.001, freedom) < result.end_cost < chi2.ppf(0.999, freedom)


def test_a_wrong_clock_costs_much() -> None:
    """The residuals of a hand in motion are those of poses at the right times."""
    module = script("hand_eye")
    poses = module.sweep(seconds=12.0)
    model = module.moving(poses)
    model.X, model.Y = (
        [*t[:3, 3], *module.quat_from_matrix(t[:3, :3])] for t in (poses.x, poses.y)
    )
    model.offset = poses.offset
    right = model.cost()
    freedom = 6 * len(poses.shot)
    assert chi2.ppf(0.001, freedom) < right < chi2.ppf(0.999, freedom)
    model.offset = poses.offset + 0.01
    assert model.cost() > 5 * right


def test_command_line(tmp_path: Path, monkeypatch, capsys) -> None:
    text = printed("hand_eye", ["--data", str(tmp_path)], monkeypatch, capsys)
    assert "A X = Y B: converged, cost 148.6 of 180 residuals" in text
    for name in ("hand_eye", "robot_world", "hand_eye_offset"):
        model, data = EXAMPLES / "hand_eye" / f"{name}.arael", tmp_path / f"{name}.json"
        assert run(["solve", "--interpret", str(model), str(data)]) == 0
        shown = capsys.readouterr().out
        assert "step of X.rotation.x" in shown
