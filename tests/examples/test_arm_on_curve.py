"""arm_on_curve: the tip is on the curve, accelerations are those of SciPy's SLSQP."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize

from tests.examples.command import solved_by_command
from tests.examples.scripts import printed, script


@pytest.fixture(scope="module")
def module():
    return script("arm_on_curve")


def test_the_optimum_is_that_of_slsqp(module) -> None:
    model = module.problem(times=6, interpret=True)
    result = model.solve()
    assert result.converged
    target = module.curve(6)

    def accelerations(x):
        return 100 * np.diff(x.reshape(6, 3), n=2, axis=0).ravel()

    found = minimize(
        lambda x: 1e-3 * accelerations(x) @ accelerations(x),
        model.poses.q.value.ravel() + 0.01,
        method="SLSQP",
        bounds=[(-1, 1.5), (0, 1.2), (0.2, 2)] * 6,
        constraints={
            "type": "eq",
            "fun": lambda x: (module.joints(x.reshape(6, 3))[:, -1] - target).ravel(),
        },
        options={"ftol": 1e-13, "maxiter": 500},
    )
    assert found.success
    assert result.cost == pytest.approx(1e3 * found.fun, rel=1e-4)
    assert module.joints(model.poses.q.value)[:, -1] == pytest.approx(target, abs=1e-9)


def test_report(module, monkeypatch, capsys, tmp_path: Path) -> None:
    text = printed("arm_on_curve", ["--interpret"], monkeypatch, capsys)
    assert "converged: the tip is within 1e-09 m of the curve" in text
    assert "limits of joints act at 1 of 20 times" in text
    text = printed("arm_on_curve", ["--interpret", "--size", "1.4"], monkeypatch, capsys)
    assert text.startswith("infeasible; these cannot hold together:\nPose.on_curve at poses[")


def test_the_command_line_finds_the_same(module, tmp_path: Path, capsys) -> None:
    model = module.problem(interpret=True)
    model.write(tmp_path / "arm.json")
    cost = solved_by_command(module.MODEL, tmp_path / "arm.json", capsys, "--interpret")
    assert cost == pytest.approx(model.solve().cost, rel=1e-9)
