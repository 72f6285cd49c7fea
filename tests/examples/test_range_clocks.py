"""range_clocks against the truth, against SciPy, and its start."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from scipy.stats import chi2

import arael
from benchmarks.by_scipy import range_clocks as by_scipy
from tests.examples.scripts import script


@pytest.fixture(autouse=True)
def interpreted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Kernels are not the point here, and compiling them takes longest."""
    monkeypatch.setattr(arael, "load", partial(arael.load, interpret=True))


def test_start_and_optimum_are_those_of_scipy() -> None:
    module, drive, start, knots, sigmas = by_scipy.data(seed=3)
    model = module.problem(drive)
    first = by_scipy.residuals(start, drive, knots, sigmas)
    assert model.cost() == pytest.approx(first @ first, rel=1e-9)
    result = model.solve(rel_precision=1e-10)
    best = by_scipy.solve(start, drive, knots, sigmas)
    assert result.end_cost == pytest.approx(2 * best.cost, rel=1e-6)
    # The skew to a hundredth of its standard deviation, the others to a thirtieth.
    scale = [1e-5, 2e-7, *[1e-3] * (len(start) - 2 - 2 * len(knots))]
    found = best.x[: -2 * len(knots)]
    assert module.solution(model) / scale == pytest.approx(found / scale, abs=1)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_truth_is_within_the_covariance(seed: int) -> None:
    module = script("range_clocks")
    drive = module.simulate(seed=seed)
    model = module.problem(drive)
    result = model.solve()
    assert result.status == "converged"
    off = module.solution(model) - drive.truth
    assert off @ np.linalg.solve(module.covariance(model), off) < chi2.ppf(0.999, len(off))
    freedom = len(drive.ranges) + 2 * len(drive.t) - 2 * len(model.knots) - len(off)
    assert chi2.ppf(0.001, freedom) < result.end_cost < chi2.ppf(0.999, freedom)
    assert np.sqrt(module.covariance(model)[0, 0]) < 1e-3  # the offset, to 1 ms


@pytest.mark.parametrize("offset", [-0.93, -0.2, 0.61])
def test_the_start_needs_no_guess(offset: float) -> None:
    """Nor does the solve: no look-up leaves its rows, none at the start is behind them."""
    module = script("range_clocks")
    drive = module.simulate(seed=4, offset=offset)
    start = module.start(drive)
    assert start[0] == pytest.approx(offset, abs=module.FIX_STEP / 5)
    assert start[2:] == pytest.approx(drive.truth[2:], abs=0.5)
    model = module.problem(drive)
    model.solve()
    assert float(model.offset.value) == pytest.approx(offset, abs=4e-3)


def test_a_far_start_is_led_to_the_same_end() -> None:
    """The offset begins at zero, between other control points."""
    module = script("range_clocks")
    drive = module.simulate(seed=5)
    near, first = module.problem(drive), module.start(drive)
    far = module.problem(drive, np.array([0.0, *first[1:]]))
    near.solve(rel_precision=1e-10)
    far.solve(rel_precision=1e-10)
    assert module.solution(far) == pytest.approx(module.solution(near), abs=1e-5)


def test_skew_that_is_left_out_is_seen() -> None:
    """A clock that is slower by 0.2 % does not fit a constant offset."""
    module = script("range_clocks")
    drive = module.simulate(seed=6, skew=2e-3)
    model = module.problem(drive)
    model.skew.fixed = True
    freedom = len(drive.ranges) + 2 * len(drive.t) - 2 * len(model.knots) - 10
    assert model.solve().end_cost > 2 * chi2.ppf(0.999, freedom)
    model.skew.fixed = False
    assert model.solve().end_cost < chi2.ppf(0.999, freedom)
