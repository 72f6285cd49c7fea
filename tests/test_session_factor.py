"""Marginals with the memory of the session's linear solver."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import arael
from arael import notes, session_factor
from arael.analysis.covariance import Covariance
from tests.analysis.maps import planar


@pytest.fixture
def solved(tmp_path: Path):
    model = planar(tmp_path, count=60)
    model.solve()
    return model


def test_a_marginal_after_a_solve_is_that_of_a_factor_of_its_own(solved, monkeypatch) -> None:
    expected = Covariance(solved._problem())
    found = solved.covariance()
    monkeypatch.setattr(Covariance, "_block", None)  # by the session alone
    for row in (-1, 0, 17):
        marginal = found.marginal(solved.poses[row])
        j = solved.jacobian().dense()
        inverse = np.linalg.inv(j.T @ j)
        at = 3 * (row % 60) + np.arange(3)
        assert marginal == pytest.approx(inverse[np.ix_(at, at)], rel=1e-8, abs=1e-14)
    assert found.marginal(("poses", 59)) == pytest.approx(found.marginal(solved.poses[-1]))
    monkeypatch.undo()
    # All else is as before.
    assert found.names == expected.names
    assert found.sigma() == pytest.approx(expected.sigma())
    assert found.cross("poses[1]", "poses[2]") == pytest.approx(
        expected.cross("poses[1]", "poses[2]")
    )


@pytest.mark.parametrize("solver", ["dense", "band", "sparse", "schur"])
def test_every_solver(tmp_path: Path, solver: str) -> None:
    model = planar(tmp_path, count=30)
    model.poses[3].t.fixed = [True, False]
    model.solve(solver=solver)
    found = model.covariance()
    expected = Covariance(model._problem())
    for row in (3, 29):
        assert found.marginal(model.poses[row]) == pytest.approx(
            expected.marginal(model.poses[row]), rel=1e-8, abs=1e-14
        )


def test_it_is_that_of_its_own_time(solved) -> None:
    """Later solves and values do not change it, nor another covariance."""
    first = solved.covariance()
    expected = Covariance(solved._problem()).marginal("poses[40]")
    solved.poses.t.value = solved.poses.t.value * 1.5
    second = solved.covariance()
    assert first.marginal(solved.poses[40]) == pytest.approx(expected)
    assert second.marginal(solved.poses[40]) == pytest.approx(
        Covariance(solved._problem()).marginal("poses[40]")
    )
    solved.solve()
    assert first.marginal(solved.poses[40]) == pytest.approx(expected)
    solved.session.release()
    assert first.marginal(solved.poses[41]).shape == (3, 3)


def test_what_is_free_is_still_refused(tmp_path: Path) -> None:
    model = planar(tmp_path, fixes=0)
    model.solve()
    with pytest.raises(arael.SolveError, match="3 of 24 directions are free"):
        model.covariance()
    model.poses[0].t.fixed = model.poses[0].th.fixed = True
    model.solve()
    assert model.covariance().marginal(model.poses[4]).shape == (3, 3)
    with pytest.raises(arael.AraelError, match="not solved for"):
        model.covariance().marginal(model.poses[0])
    model.poses[0].th.fixed = False
    model.solve()
    with pytest.raises(arael.SolveError, match="1 of 22 directions are free"):
        model.covariance()


def test_a_solve_within_a_solve_leaves_the_factor_alone(solved) -> None:
    """An observer that asks for covariances gets them, from a factor of their own."""
    seen = []

    def look(_) -> None:
        seen.append(solved.covariance().marginal(solved.poses[5]))

    solved.poses.t.value = solved.poses.t.value + 0.1
    plain = solved.cost()
    result = solved.solve(observer=look)
    assert seen
    assert result.converged
    assert result.end_cost < plain


def test_symmetries_of_large_problems_are_looked_for_once(tmp_path: Path, monkeypatch) -> None:
    asked = []
    monkeypatch.setattr(notes, "_MOST", 0)
    monkeypatch.setattr(session_factor, "has_symmetries", lambda p: bool(asked.append(1)))
    model = planar(tmp_path)
    for _ in range(3):
        model.poses.t.value = model.poses.t.value + 0.01
        model.solve()
        model.covariance()
    assert len(asked) == 1
    # Added measurements hold what was held; with fewer of them it is asked again.
    model.fixes.append(pose=model.poses[1], t=[0.0, 0.0])
    model.solve()
    model.covariance()
    assert len(asked) == 1
    model.fixes.pop()
    model.solve()
    model.covariance()
    assert len(asked) == 2
