"""Unknowns of very many equations: their copies change no result."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from arael.runtime.orthogonal import copies
from tests.runtime.orthogonal.matrices import Doubles, integer_matrices, of_rows, sparse

CHECKS = settings(
    max_examples=80,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)


@pytest.fixture(autouse=True)
def nearly_all(monkeypatch: pytest.MonkeyPatch) -> None:
    """Copies for each unknown of more than two equations, one for each."""
    monkeypatch.setattr(copies, "MANY", 2)
    monkeypatch.setattr(copies, "EACH", 1)


def test_the_pattern_has_an_equation_for_each_further_copy() -> None:
    indptr = np.array([0, 2, 3, 5, 6], dtype=np.int32)
    indices = np.array([0, 1, 1, 1, 2, 2], dtype=np.int32)
    starts, places, origin, share = copies.with_copies(3, indptr, indices)
    assert starts.tolist() == [0, 2, 3, 5, 6, 8, 10]
    assert places.tolist() == [0, 1, 3, 4, 2, 2, 1, 3, 3, 4]
    assert origin.tolist() == [0, 1, 2, 1, 1]
    assert share**2 == pytest.approx([1, 3, 1, 3, 3])


@CHECKS
@given(integer_matrices(12, 8), st.integers(0, 2**32))
def test_results_are_those_of_dense_matrices(dense: Doubles, seed: int) -> None:
    rng = np.random.default_rng(seed)
    m, n = dense.shape
    made = sparse(dense).factored(np.ones(n))
    rank = int(np.linalg.matrix_rank(dense)) if dense.size else 0
    assert (made.rank, made.nullity) == (rank, n - rank)
    kept: list[int] = []
    for i in range(m):
        if n and np.linalg.matrix_rank(dense[[*kept, i]]) > len(kept):
            kept.append(i)
    assert np.flatnonzero(made.independent).tolist() == kept
    assert len(made.dependent) == m - rank
    for i in made.dependent.tolist():
        found = made.dependency(i)
        assert found.factors @ dense[found.equations] == pytest.approx(dense[i], abs=1e-9)
    basis = made.null_vectors().dense()
    assert basis @ basis.T == pytest.approx(np.eye(n - rank), abs=1e-12)
    assert np.abs(dense @ basis.T).max(initial=0) < 1e-12
    vector = rng.normal(size=n)
    inverse = np.linalg.pinv(dense) if dense.size else np.zeros((n, m))
    assert made.least_norm(dense @ vector) == pytest.approx(inverse @ dense @ vector, abs=1e-10)
    found = made.dependency_of(np.arange(n), vector)
    length = np.linalg.norm(vector) or 1.0
    assert found.remainder == pytest.approx(np.linalg.norm(basis @ vector) / length, abs=1e-12)
    nearest = vector - basis.T @ (basis @ vector)
    assert found.factors @ dense[found.equations] == pytest.approx(nearest, abs=1e-9)


def test_two_thousand_equal_radii(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.undo()
    count = 2000
    made = of_rows(count + 1, [([0, i], [-1.0, 1.0]) for i in range(1, count + 1)]).factored()
    assert (made.rank, made.nullity) == (count, 1)
    assert np.abs(made.null_vectors().dense()) == pytest.approx((count + 1) ** -0.5)
    found = made.dependency_of([5, 1900], [-1.0, 1.0])
    assert found.remainder < 1e-12
    assert found.equations.tolist() == [4, 1899]
    assert found.factors == pytest.approx([-1.0, 1.0])
