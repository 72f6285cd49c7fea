"""Null space, least-norm solutions."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.runtime.orthogonal.matrices import (
    Doubles,
    Row,
    beams,
    integer_matrices,
    of_rows,
    polygon,
    sparse,
)


@settings(max_examples=100, deadline=None)
@given(integer_matrices(12, 12), st.integers(0, 2**32))
def test_null_vectors_are_an_orthonormal_basis(dense: Doubles, seed: int) -> None:
    rng = np.random.default_rng(seed)
    m, n = dense.shape
    scaled = dense * 10.0 ** rng.integers(-6, 7, n) * 10.0 ** rng.integers(-6, 7, (m, 1))
    made = sparse(scaled).factored()
    of_equations, of_unknowns = made.scales
    basis = made.null_vectors().dense() / of_unknowns
    assert basis.shape == (n - made.rank, n)
    assert basis @ basis.T == pytest.approx(np.eye(len(basis)), abs=1e-12)
    assert np.abs(of_equations[:, None] * scaled * of_unknowns @ basis.T).max(initial=0) < 1e-11


@settings(max_examples=80, deadline=None)
@given(integer_matrices(), st.integers(0, 2**32))
def test_least_norm_solution(dense: Doubles, seed: int) -> None:
    rng = np.random.default_rng(seed)
    m, n = dense.shape
    made = sparse(dense).factored(np.ones(n))
    inverse = np.linalg.pinv(dense) if dense.size else np.zeros((n, m))
    vectors = rng.normal(size=(3, n))
    right = vectors @ dense.T
    assert made.least_norm(right) == pytest.approx(right @ inverse.T, abs=1e-9)
    assert made.least_norm(right[0]) == pytest.approx(inverse @ right[0], abs=1e-9)


@settings(max_examples=40, deadline=None)
@given(integer_matrices(), st.integers(0, 2**32))
def test_inconsistent_right_sides_hold_on_the_independent_equations(
    dense: Doubles, seed: int
) -> None:
    made = sparse(dense).factored()
    right = np.random.default_rng(seed).normal(size=len(dense))
    kept = made.independent
    assert (dense @ made.least_norm(right))[kept] == pytest.approx(right[kept], abs=1e-8)


def test_scales_of_unknowns_are_the_metric() -> None:
    made = sparse(np.array([[1.0, 1.0]])).factored(np.array([1.0, 2.0]))
    # Least of d0^2 + (d1 / 2)^2 with d0 + d1 = 5.
    assert made.least_norm([5.0]) == pytest.approx([1.0, 4.0])


def test_least_norm_of_a_long_chain_is_accurate() -> None:
    made = beams(3_000)
    x = np.sin(np.arange(made.n) / 100)
    found = made.factored(np.ones(made.n)).least_norm(made.times(x))
    # Condition 10^7; by the normal equations nothing would be left.
    assert np.abs(made.times(found - x)).max() < 1e-12
    assert np.abs(found - x).max() < 1e-7


def test_what_can_move_and_what_cannot() -> None:
    # x0 is fixed, x1 with it, x2 and x3 move together, x4 is in no equation.
    dense = np.array([[1.0, 0, 0, 0, 0], [-1, 1, 0, 0, 0], [0, 0, 1, -1, 0]])
    made = sparse(dense).factored()
    assert made.nullity == 2
    lengths = np.linalg.norm(made.null_vectors().dense() / made.scales[1], axis=0)
    assert lengths == pytest.approx([0, 0, np.sqrt(0.5), np.sqrt(0.5), 1])


def test_null_vectors_stay_where_they_belong() -> None:
    # 50 tied pairs in a chain that is fixed everywhere, each with a free unknown beside it.
    rows: list[Row] = [([0], [1.0])]
    for i in range(50):
        rows.append(([3 * i, 3 * i + 1, 3 * i + 2], [1.0, 2.0, -1.0]))
        if i:
            rows.append(([3 * i - 3, 3 * i], [1.0, -1.0]))
    vectors = of_rows(150, rows).factored().null_vectors()
    assert len(vectors) == 50
    seen = []
    for k in range(50):
        at, _ = vectors.vector(k)
        assert len({u // 3 for u in at.tolist()}) == 1
        seen.append(at[0] // 3)
    assert sorted(seen) == list(range(50))


def test_vectors_of_one_component_have_nothing_of_another() -> None:
    one = np.random.default_rng(0).normal(size=(3, 5))
    dense = np.block([[one, np.zeros((3, 5))], [np.zeros((3, 5)), one]])
    vectors = sparse(dense).factored().null_vectors().dense()
    assert len(vectors) == 4
    assert all(not row[:5].any() or not row[5:].any() for row in vectors)


def test_a_polygon_of_equal_sides() -> None:
    made = polygon(128)
    factor = made.factored()
    dense = np.zeros((made.m, made.n))
    dense[np.repeat(np.arange(made.m), np.diff(made.indptr)), made.indices] = made.entries
    assert factor.nullity == 256 - np.linalg.matrix_rank(dense) == 129
    assert factor.null_vectors().dense().any(axis=0).all()
