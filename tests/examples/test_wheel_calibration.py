"""wheel_calibration against the truth, against SciPy, and its start."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from scipy.stats import chi2

import arael
from benchmarks.by_scipy import wheel_calibration as by_scipy
from tests.examples.scripts import script


@pytest.fixture(autouse=True)
def interpreted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Kernels are not the point here, and compiling them takes longest."""
    monkeypatch.setattr(arael, "load", partial(arael.load, interpret=True))


def test_start_and_optimum_are_those_of_scipy() -> None:
    module = script("wheel_calibration")
    drive = module.simulate(motions=200, seed=3)
    model = module.calibration(drive)
    first, sigmas = module.start(drive), (float(model.step_sigma), float(model.turn_sigma))
    start = by_scipy.residuals(first, by_scipy.path_of(drive), drive, sigmas)
    assert model.cost() == pytest.approx(start @ start, rel=1e-9)
    result = model.solve(rel_precision=1e-10)
    best = by_scipy.solve(first, drive, sigmas)
    assert result.end_cost == pytest.approx(2 * best.cost, rel=1e-7)
    assert module.solution(model) == pytest.approx(best.x, abs=1e-5)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_truth_is_within_the_covariance(seed: int) -> None:
    module = script("wheel_calibration")
    drive = module.simulate(seed=seed)
    model = module.calibration(drive)
    result = model.solve()
    off = module.solution(model) - drive.truth
    assert off @ np.linalg.solve(module.covariance(model), off) < chi2.ppf(0.999, 5)
    freedom = 3 * len(drive.t0) - 5
    assert chi2.ppf(0.001, freedom) < result.end_cost < chi2.ppf(0.999, freedom)


def test_the_start_needs_no_guess() -> None:
    module = script("wheel_calibration")
    drive = module.simulate(seed=4)
    off = np.abs(module.start(drive) - drive.truth)
    assert (off < [0.02, 0.02, 0.02, 0.02, 0.003]).all()


def test_a_far_start_is_led_to_the_same_end() -> None:
    """The offset begins 40 rows of the odometer away."""
    module = script("wheel_calibration")
    drive = module.simulate(motions=300, seed=5)
    near = module.calibration(drive)
    far = module.calibration(drive, np.array([0.0, 0.0, 0.0, 1.0, 0.45]))
    near.solve(rel_precision=1e-10)
    far.solve(rel_precision=1e-10)
    assert module.solution(far) == pytest.approx(module.solution(near), abs=1e-5)
