"""arm_calibration against the truth, against SciPy, on the command line."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import chi2

import arael
from arael.cli.main import run
from benchmarks.by_scipy import arm_calibration as by_scipy
from tests.examples.scripts import EXAMPLES, printed, script

MODEL = EXAMPLES / "arm_calibration" / "arm_calibration.arael"


@pytest.fixture(autouse=True)
def interpreted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Kernels are not the point here, and compiling them takes longest."""
    monkeypatch.setattr(arael, "load", partial(arael.load, interpret=True))


def test_six_directions_are_free_and_named() -> None:
    module = script("arm_calibration")
    free = module.problem(module.simulate()).free_directions()
    assert len(free) == 6
    text = str(free)
    # The first link moves as the base does, the last as the tool.
    assert "+1 base.translation.z -1 joints[0].d" in text
    assert "+1 base.rotation.z -1 joints[0].theta" in text
    assert all(f"joints[6].{name}" in text for name in module.NAMES)
    assert not module.held(module.simulate()).free_directions()


def test_the_optimum_is_that_of_scipy() -> None:
    module = script("arm_calibration")
    arm = module.simulate(seed=3)
    model = module.held(arm)
    result = model.solve(rel_precision=1e-9)
    assert result.end_cost == pytest.approx(2 * by_scipy.solve(arm).cost, rel=1e-6)


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("form", ["held", "with_priors"])
def test_the_truth_is_within_the_covariance(form: str, seed: int) -> None:
    module = script("arm_calibration")
    arm = module.simulate(seed=seed)
    model = getattr(module, form)(arm)
    result = model.solve(rel_precision=1e-9)
    covariance = model.covariance()
    names = [
        f"joints[{k}].{name}" for k in range(7) for name in module.NAMES
        if f"joints[{k}].{name}" in covariance.names
    ]  # fmt: skip
    assert len(names) == (25 if form == "held" else 28)
    off = np.array([
        arm.links[int(name[7]), module.NAMES.index(name.split(".")[1])] - value
        for name, value in zip(names, [eval_at(model, name) for name in names], strict=True)
    ])  # fmt: skip
    assert off @ np.linalg.solve(covariance.marginal(names), off) < chi2.ppf(0.999, len(off))
    assert result.end_cost < chi2.ppf(0.999, model.jacobian().shape[0] - len(covariance.names))
    assert module.prediction(model, arm) < 2e-4


def eval_at(model: object, name: str) -> float:
    """Value of `joints[3].alpha`."""
    return float(getattr(model.joints[int(name[7])], name.split(".")[1]).value)  # type: ignore[attr-defined]


def test_command_line(tmp_path: Path, monkeypatch, capsys) -> None:
    text = printed("arm_calibration", ["--data", str(tmp_path)], monkeypatch, capsys)
    assert "6 of 37 directions are free" in text
    assert "held: converged" in text
    free, held = (str(tmp_path / f"arm_{name}.json") for name in ("free", "held"))
    assert run(["diagnose", str(MODEL), free]) == 1
    shown = capsys.readouterr().out
    assert "6 of 37 directions are free" in shown
    assert run(["solve", "--interpret", str(MODEL), held, "--show", "joints[:7]"]) == 0
    shown = capsys.readouterr().out
    assert "(fixed)" in shown
