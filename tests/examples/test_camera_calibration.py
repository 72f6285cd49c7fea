"""camera_calibration against the truth, against SciPy, on the command line."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import chi2

import arael
from arael.cli.main import run
from benchmarks.by_scipy import camera_calibration as by_scipy
from tests.examples.scripts import EXAMPLES, printed, script

MODEL = EXAMPLES / "camera_calibration" / "camera_calibration.arael"


@pytest.fixture(autouse=True)
def interpreted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Kernels are not the point here, and compiling them takes longest."""
    monkeypatch.setattr(arael, "load", partial(arael.load, interpret=True))


@pytest.mark.slow
def test_start_and_optimum_are_those_of_scipy() -> None:
    module = script("camera_calibration")
    seen = module.simulate(views=6, seed=3)
    rig = module.problem(seen)
    start = by_scipy.residuals(by_scipy.start(seen), seen)
    assert rig.cost() == pytest.approx(start @ start, rel=1e-9)
    result = rig.solve(rel_precision=1e-9)
    assert result.end_cost == pytest.approx(2 * by_scipy.solve(seen).cost, rel=1e-5)


@pytest.mark.sweep(3)
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_truth_is_within_the_joint_covariance(seed: int) -> None:
    module = script("camera_calibration")
    rig = module.problem(module.simulate(seed=seed))
    result = rig.solve(rel_precision=1e-9)
    names, values, covariance = module.intrinsics(rig)
    assert len(names) == 16
    off = values - np.concatenate([lens.intrinsics for lens in module.LENSES])
    assert off @ np.linalg.solve(covariance, off) < chi2.ppf(0.999, 16)
    freedom = rig.jacobian().shape[0] - len(rig.parameter_names())
    assert chi2.ppf(0.001, freedom) < result.end_cost < chi2.ppf(0.999, freedom)
    # The focal lengths of the two cameras are found from the same poses of the target.
    assert covariance[0, 8] / np.sqrt(covariance[0, 0] * covariance[8, 8]) > 0.3


def test_the_mount_is_within_its_covariance() -> None:
    module = script("camera_calibration")
    rig = module.problem(module.simulate(seed=2))
    rig.solve(rel_precision=1e-9)
    mount, lens = rig.cameras[1].mount, module.LENSES[1]
    turn = mount.rotation_matrix
    off = np.concatenate([
        turn.T @ (lens.t - mount.translation),
        module.arael.geometry.rotation_vector(turn.T @ module.rotation_from_vector(lens.v)),
    ])  # fmt: skip
    covariance = rig.covariance().marginal("cameras[1].mount")
    assert off @ np.linalg.solve(covariance, off) < chi2.ppf(0.999, 6)


def test_command_line(tmp_path: Path, monkeypatch, capsys) -> None:
    data = tmp_path / "rig.json"
    text = printed("camera_calibration", ["--data", str(data)], monkeypatch, capsys)
    assert "3128 residuals, 112 parameters" in text
    out = tmp_path / "solved.json"
    assert run(["solve", "--interpret", str(MODEL), str(data), "-o", str(out)]) == 0
    solved = json.loads(out.read_text())
    assert solved["cameras"][0]["f"] == pytest.approx([612, 609], abs=2)
