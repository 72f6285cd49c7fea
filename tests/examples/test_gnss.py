"""gnss: truth within its sigmas, the optimum of SciPy, reflections among the residuals."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from benchmarks import trajectories
from tests.examples.command import solved_by_command
from tests.examples.scripts import printed, script


@pytest.fixture(scope="module")
def module():
    return script("gnss")


def test_the_truth_is_within_its_sigmas(module) -> None:
    drive = module.make_drive(60, seed=1)
    model = module.problem(drive)
    result = model.solve()
    assert result.components.converged.all()
    covariance = model.covariance()
    squares = []
    for row, pos, clock in zip(model.epochs, drive.true_pos, drive.true_clock, strict=True):
        wrong = np.append(np.asarray(row.pos.value) - pos, float(row.clock.value) - clock)
        squares.append(wrong @ np.linalg.solve(covariance.marginal(row), wrong))
    assert 2 < np.median(squares) < 5  # chi-square of 4, and reflections


def test_the_optimum_is_that_of_scipy(module) -> None:
    beside = trajectories.gnss(module, module.make_drive(20, seed=1))
    model = beside.make()
    at_start = beside.residuals(beside.start)
    result = model.solve(passes="fine", rel_precision=1e-12)
    assert result.start_cost == pytest.approx(at_start @ at_start, rel=1e-6)
    # Differences of distances of 2e7 m are good to nine digits: SciPy ends 1e-4 above the optimum.
    solution = np.column_stack(
        [np.array(model.epochs.pos.value), np.array(model.epochs.clock.value)]
    )
    here = beside.residuals(solution.ravel())
    assert result.end_cost == pytest.approx(here @ here, rel=1e-6)
    assert 2 * beside.by_scipy().cost == pytest.approx(result.end_cost, rel=3e-4)
    from_here = beside._replace(start=solution.ravel()).by_scipy(ftol=1e-14, xtol=1e-15)
    assert 2 * from_here.cost == pytest.approx(result.end_cost, rel=1e-6)


def test_an_epoch_is_solved_as_if_it_were_alone(module) -> None:
    drive = module.make_drive(20, seed=1)
    model = module.problem(drive)
    model.solve(rel_precision=1e-12)
    first = drive.epoch == 0
    one = dataclasses.replace(
        drive,
        epoch=drive.epoch[first],
        satellite=drive.satellite[first],
        range=drive.range[first],
        sigma=drive.sigma[first],
        true_pos=drive.true_pos[:1],
    )
    alone = module.problem(one)
    alone.solve(rel_precision=1e-12)
    np.testing.assert_allclose(alone.epochs.pos.value, model.epochs.pos.value[:1], atol=1e-3)


def test_the_command_line_finds_the_same(module, tmp_path: Path, capsys) -> None:
    model = module.problem(module.make_drive(50))
    model.write(tmp_path / "gnss.npz")
    cost = solved_by_command(module.MODEL, tmp_path / "gnss.npz", capsys)
    assert cost == pytest.approx(model.solve().end_cost, rel=1e-6)


def test_report(monkeypatch, capsys) -> None:
    out = printed("gnss", [], monkeypatch, capsys)
    assert "1000 of 1000 components converged" in out
    assert "193 beyond 4 sigmas, of which 191 are reflections (there are 200)" in out
