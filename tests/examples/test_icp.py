"""icp against the truth, against SciPy, on the command line."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

import arael
from arael.cli.main import run
from benchmarks.by_scipy import icp as by_scipy
from tests.examples.scripts import EXAMPLES, printed, script


@pytest.fixture(autouse=True)
def interpreted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Kernels are not the point here, and compiling them takes longest."""
    monkeypatch.setattr(arael, "load", partial(arael.load, interpret=True))


@pytest.mark.slow
def test_the_loop_ends_where_that_of_scipy_does() -> None:
    module = script("icp")
    scans = module.simulate(points=500, seed=2)
    known = module.planes(scans.fixed)
    found = module.align(scans, known)
    x, cost = by_scipy.align(scans, *known)
    assert found.model.cost() == pytest.approx(cost, rel=1e-5)
    assert found.model.T.translation == pytest.approx(x[3:], abs=1e-5)
    assert found.model.T.rotation_matrix == pytest.approx(
        Rotation.from_rotvec(x[:3]).as_matrix(), abs=1e-5
    )


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_truth_is_within_the_covariance(seed: int) -> None:
    module = script("icp")
    scans = module.simulate(seed=seed)
    found = module.align(scans, module.planes(scans.fixed))
    off = module.error(found.model, scans)
    covariance = found.model.covariance().marginal("T")
    assert off @ np.linalg.solve(covariance, off) < chi2.ppf(0.999, 6)
    assert len(found.moves) < 15
    someone = len(scans.moved) - (len(scans.moved) - len(scans.moved) // 13)
    assert module.used(found)[-someone:].mean() < 0.1


def test_rounds_use_one_layout() -> None:
    module = script("icp")
    scans = module.simulate(points=300)
    found = module.align(scans, module.planes(scans.fixed))
    assert len(found.moves) > 2
    again = found.model.solve()
    assert again.end_cost == pytest.approx(found.model.cost())
    assert again.timing["analyse"] == 0


def test_command_line(tmp_path: Path, monkeypatch, capsys) -> None:
    data = tmp_path / "icp.json"
    text = printed("icp", ["--points", "500", "--data", str(data)], monkeypatch, capsys)
    assert "of the points count at the end" in text
    model = EXAMPLES / "icp" / "icp.arael"
    assert run(["solve", "--interpret", str(model), str(data)]) == 0
    shown = capsys.readouterr().out
    assert "step of T.rotation.x" in shown
