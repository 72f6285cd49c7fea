"""Covariances taken apart and put together."""

from __future__ import annotations

import numpy as np
import pytest

from arael.diagnostics.records import AraelError
from arael.geometry import compose_covariance, decompose_covariance, ellipsoid, whiten

RNG = np.random.default_rng(5)
ROOT = RNG.normal(size=(6, 3, 3))
K = ROOT @ np.swapaxes(ROOT, -1, -2)


def test_axes_are_rotations_and_give_the_covariance_back() -> None:
    cov_r, isigma = decompose_covariance(K)
    assert np.linalg.det(cov_r) == pytest.approx(1)
    assert compose_covariance(cov_r, isigma) == pytest.approx(K)
    assert 1 / isigma[2] ** 2 == pytest.approx(np.linalg.eigvalsh(K[2]))


def test_whitened_squares_are_the_mahalanobis_distance() -> None:
    raw = RNG.normal(size=(6, 3))
    white = whiten(raw, *decompose_covariance(K))
    assert np.sum(white**2, axis=1) == pytest.approx(
        [e @ np.linalg.solve(k, e) for e, k in zip(raw, K, strict=True)]
    )


def test_ellipsoid() -> None:
    turn = np.array([[0.8, -0.6], [0.6, 0.8]])
    axes, directions = ellipsoid(turn @ np.diag([4.0, 0.09]) @ turn.T)
    assert axes == pytest.approx([2.0, 0.3])
    assert np.abs(directions[:, 0] @ turn[:, 0]) == pytest.approx(1)
    assert ellipsoid(np.diag([1.0, 0.0]))[0] == pytest.approx([1, 0])


@pytest.mark.parametrize(
    ("covariance", "message"),
    [
        ([[1.0, 0.0], [0.0, 0.0]], "`covariance` is not positive definite: its smallest"),
        ([np.eye(2), [[1.0, 2.0], [2.0, 1.0]]], r"`covariance\[1\]` is not positive definite"),
        ([[1.0, 0.5], [0.0, 1.0]], "not symmetric"),
        ([[np.nan, 0.0], [0.0, 1.0]], "not finite"),
    ],
)
def test_impossible_covariances(covariance: object, message: str) -> None:
    with pytest.raises(AraelError, match=message) as error:
        decompose_covariance(covariance)  # type: ignore[arg-type]
    assert error.value.diagnostics[0].code == "E1030"


def test_not_square() -> None:
    with pytest.raises(AraelError, match="E1031"):
        decompose_covariance(np.zeros((2, 3)))
