"""Covariances against the dense inverse, and against what noise really does."""

from __future__ import annotations

import numpy as np
import pytest

from arael.diagnose import normal
from arael.diagnostics.records import AraelError
from tests.diagnose.maps import planar


@pytest.fixture
def solved(tmp_path):
    model = planar(tmp_path)
    model.solve(rel_precision=1e-12, abs_precision=1e-12)
    return model


def test_every_query_against_the_dense_inverse(solved) -> None:
    j = solved.jacobian().dense()
    inverse = np.linalg.inv(j.T @ j)
    found = solved.covariance()
    np.testing.assert_allclose(found.sigma(), np.sqrt(np.diag(inverse)), rtol=1e-8)
    names = found.names
    a = [names.index(f"poses[2].{n}") for n in ("t.x", "t.y", "th")]
    b = [names.index(f"poses[5].{n}") for n in ("t.x", "t.y", "th")]
    aa, ab, bb = (inverse[np.ix_(i, j)] for i, j in ((a, a), (a, b), (b, b)))
    pose, other = solved.poses[2], solved.poses[5]
    np.testing.assert_allclose(found.marginal(pose), aa, rtol=1e-8, atol=1e-15)
    np.testing.assert_allclose(found.cross(pose, other), ab, rtol=1e-8, atol=1e-15)
    np.testing.assert_allclose(
        found.relative(pose, other), aa + bb - ab - ab.T, rtol=1e-7, atol=1e-15
    )
    np.testing.assert_allclose(
        found.conditional(pose, other), aa - ab @ np.linalg.solve(bb, ab.T), rtol=1e-7, atol=1e-15
    )
    np.testing.assert_allclose(
        found.conditional(pose), np.linalg.inv((j.T @ j)[np.ix_(a, a)]), rtol=1e-8, atol=1e-15
    )
    np.testing.assert_allclose(found.marginal("poses[2].th"), aa[2:, 2:], rtol=1e-8)
    whole = found.marginals("poses")
    assert whole.shape == (8, 3, 3)
    np.testing.assert_allclose(whole[2], aa, rtol=1e-8, atol=1e-15)
    np.testing.assert_allclose(found.marginals("poses.t")[2], aa[:2, :2], rtol=1e-8, atol=1e-15)
    axes, directions = found.ellipsoid("poses[2].t")
    np.testing.assert_allclose(directions @ np.diag(axes**2) @ directions.T, aa[:2, :2], atol=1e-12)
    np.testing.assert_allclose(found.matrix, inverse, rtol=1e-7, atol=1e-14)
    np.testing.assert_allclose(found.marginal(pose), aa, rtol=1e-8, atol=1e-15)


def test_units_are_those_of_the_scalars(solved) -> None:
    found = solved.covariance()
    assert found.units == ["m", "m", "rad"] * 8
    assert len(found.units) == len(found.names)


def test_what_is_fixed_has_no_variance(solved) -> None:
    solved.poses[3].t.fixed = True
    found = solved.covariance()
    assert found.units[9:12] == ["rad", "m", "m"]
    assert found.marginals("poses.t")[3] == pytest.approx(0)
    j = solved.jacobian().dense()
    inverse = np.linalg.inv(j.T @ j)
    np.testing.assert_allclose(found.marginals("poses")[3][2, 2], inverse[9, 9], rtol=1e-8)
    np.testing.assert_allclose(found.sigma(), np.sqrt(np.diag(inverse)), rtol=1e-8)


def test_monte_carlo(tmp_path) -> None:
    """The spread of solutions under fresh noise of the stated sigmas is what is promised."""
    found = []
    for seed in range(160):
        model = planar(tmp_path, count=5, seed=seed)
        model.solve()
        found.append(np.concatenate([model.poses.t.value[3], model.poses.t.value[1]]))
    promised = planar(tmp_path, count=5, seed=0)
    promised.solve()
    covariance = promised.covariance()
    rows = ["poses[3].t", "poses[1].t"]
    expected = np.block([[covariance.cross(a, b) for b in rows] for a in rows])
    spread = np.cov(np.array(found).T)
    # Whitened by what is promised, the sample covariance is the identity within 1/sqrt(160).
    half = np.linalg.inv(np.linalg.cholesky(expected))
    assert half @ spread @ half.T == pytest.approx(np.eye(4), abs=0.36)


def test_single_precision_models(tmp_path) -> None:
    single, double = planar(tmp_path, precision="f32"), planar(tmp_path)
    for model in (single, double):
        model.solve()
    np.testing.assert_allclose(single.covariance().sigma(), double.covariance().sigma(), rtol=1e-4)


def test_large_systems_take_the_sparse_way(solved, monkeypatch: pytest.MonkeyPatch) -> None:
    expected = solved.covariance().sigma()
    monkeypatch.setattr(normal, "_DENSE", 0)
    np.testing.assert_allclose(solved.covariance().sigma(), expected, rtol=1e-9)


def test_refusals(solved) -> None:
    found = solved.covariance()
    for ask, message in (
        (lambda: found.marginal("poses[99]"), r"`poses\[99\]` is not solved for"),
        (lambda: found.marginals("edges"), "`edges` holds no parameters"),
        (lambda: found.conditional("poses[1]", "poses[1].t"), "they overlap"),
        (lambda: found.relative("poses[1].t", "poses[1].th"), "no parameter of the same name"),
    ):
        with pytest.raises(AraelError, match=message) as error:
            ask()
        assert error.value.diagnostics[0].code == "E1009"
