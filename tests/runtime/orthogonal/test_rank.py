"""The rank and the dependent equations are those of exact arithmetic and of the SVD."""

from __future__ import annotations

import numpy as np
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

from arael.runtime.orthogonal import RankQR
from tests.runtime.orthogonal.matrices import (
    Doubles,
    Row,
    beams,
    grid,
    integer_matrices,
    of_rows,
    sparse,
)


def exact_rank(dense: Doubles) -> int:
    return int(sympy.Matrix(dense.astype(int)).rank()) if dense.size else 0


def later_ones(dense: Doubles) -> list[int]:
    """Rows that are combinations of rows before them, in exact arithmetic."""
    ranks = [exact_rank(dense[:k]) for k in range(len(dense) + 1)]
    return [i for i in range(len(dense)) if ranks[i + 1] == ranks[i]]


@settings(max_examples=80, deadline=None)
@given(integer_matrices(7, 7))
def test_rank_is_exact(dense: Doubles) -> None:
    made = sparse(dense).factored()
    assert made.rank == exact_rank(dense)
    assert made.nullity == dense.shape[1] - made.rank


@settings(max_examples=60, deadline=None)
@given(integer_matrices(7, 7))
def test_the_later_of_dependent_equations_are_called_so(dense: Doubles) -> None:
    made = sparse(dense).factored()
    assert made.dependent.tolist() == later_ones(dense)
    assert np.flatnonzero(~made.independent).tolist() == later_ones(dense)


@settings(max_examples=100, deadline=None)
@given(integer_matrices(14, 14), st.integers(0, 2**32))
def test_rank_of_badly_scaled_matrices_is_that_of_the_scaled_svd(dense: Doubles, seed: int) -> None:
    rng = np.random.default_rng(seed)
    m, n = dense.shape
    scaled = dense * 10.0 ** rng.integers(-6, 7, n) * 10.0 ** rng.integers(-6, 7, (m, 1))
    expected = np.linalg.matrix_rank(dense) if dense.size else 0
    assert sparse(scaled).factored().rank == expected


@settings(max_examples=60, deadline=None)
@given(integer_matrices(), st.integers(0, 2**32))
def test_given_scales_of_unknowns_are_used(dense: Doubles, seed: int) -> None:
    powers = np.random.default_rng(seed).integers(-6, 7, size=(dense.shape[1],))
    scale = np.power(10.0, powers)
    made = sparse(dense / scale).factored(scale)
    assert made.rank == (np.linalg.matrix_rank(dense) if dense.size else 0)
    assert np.array_equal(made.scales[1], scale)


@pytest.mark.parametrize("far", [0.2, 0.5, 2.0, 5.0])
def test_nearly_dependent_equations_are_judged_by_the_tolerance(far: float) -> None:
    tolerance = 1e-8
    dense = np.array([[1.0, 1, 0], [0, 1, 1], [1, 2, 1]])
    # Equations are scaled by powers of two: to sqrt(2), sqrt(2) and sqrt(6) / 2.
    normal = np.array([1.0, -1, 1]) / np.sqrt(3)
    dense[2] += normal * far * tolerance * 2 * np.sqrt(2)
    made = RankQR(*sparse(dense)[:4], tolerance=tolerance)
    made.factor(sparse(dense).entries, np.ones(3))
    assert made.rank == (3 if far > 1 else 2)
    assert made.threshold == pytest.approx(tolerance * np.sqrt(2))
    near = made.smallest_kept if far > 1 else made.largest_dropped
    assert near == pytest.approx(far * made.threshold, rel=1e-6)


def test_the_gap_says_how_safe_the_rank_is() -> None:
    clear = sparse(np.array([[1.0, 1], [1, 1], [0, 1]])).factored()
    assert clear.gap > 1e12
    doubtful = sparse(np.array([[1.0, 1], [1, 1 + 1e-14]])).factored()
    assert doubtful.rank == 1
    assert 1e-15 < doubtful.largest_dropped < 1e-13
    assert sparse(np.eye(3)).factored().gap == float("inf")


@pytest.mark.parametrize(
    ("dense", "rank"),
    [
        (np.zeros((0, 0)), 0),
        (np.zeros((0, 4)), 0),
        (np.zeros((3, 0)), 0),
        (np.zeros((3, 4)), 0),
        (np.array([[5.0]]), 1),
        (np.array([[0.0]]), 0),
        (np.ones((5, 1)), 1),
        (np.ones((1, 5)), 1),
        (np.ones((4, 3)), 1),
        (np.vstack([np.eye(4), np.eye(4)]), 4),
    ],
)
def test_small_and_degenerate_shapes(dense: Doubles, rank: int) -> None:
    made = sparse(dense).factored()
    assert made.rank == rank
    assert len(made.dependent) == dense.shape[0] - rank
    assert made.null_vectors().dense().shape == (dense.shape[1] - rank, dense.shape[1])


def test_entries_at_the_same_place_are_added_up() -> None:
    made = RankQR(2, 2, [0, 3, 5], [0, 1, 0, 1, 0])
    made.factor([1.0, 1.0, 1.0, 1.0, 2.0])  # (2, 1) twice
    assert made.rank == 1
    assert made.dependency(1).factors == pytest.approx([1.0])


def test_long_chains_keep_their_rank_where_the_normal_equations_lose_it() -> None:
    # Least singular value 3e-8 of the largest: its square is below the rounding errors of J J'.
    made = beams(10_000)
    factor = made.factored(np.ones(made.n))
    assert factor.rank == 10_000
    assert factor.gap == float("inf")
    at, values = [9_999], [1.0]
    found = factor.dependency_of(at, values)
    assert found.remainder < 1e-12
    back = np.zeros(made.n)
    rows = np.repeat(np.arange(made.m), np.diff(made.indptr))
    factors = np.zeros(made.m)
    factors[found.equations] = found.factors
    np.add.at(back, made.indices, made.entries * factors[rows])
    back[9_999] -= 1.0
    # x[n - 1] = sum of (n - 1 - k) times equation k: multipliers up to 10^4.
    assert found.factors == pytest.approx(np.append([-9_998.0, 9_999.0], np.arange(9_998, 0, -1)))
    assert np.abs(back).max() < 1e-10


def test_a_closed_chain_has_one_dependent_equation_the_last() -> None:
    links: list[Row] = [([0], [1.0])]
    links += [([i, i + 1], [-1.0, 1.0]) for i in range(9_999)]
    made = of_rows(10_000, [*links, ([0, 9_999], [-1.0, 1.0])]).factored()
    found = made.dependency(10_000)
    assert found.remainder < 1e-12
    assert np.array_equal(found.equations, np.arange(1, 10_000))
    assert found.factors == pytest.approx(np.ones(9_999))
    assert made.rank == 10_000
    assert made.dependent.tolist() == [10_000]
    assert made.gap > 1e8


def test_every_loop_of_a_grid_adds_a_dependent_equation() -> None:
    made = grid(20).factored()
    assert made.rank == 399
    assert len(made.dependent) == 19**2


def test_an_unknown_of_very_many_equations() -> None:
    # All radii equal to the first: one unknown in every equation.
    count = 700
    dense = np.hstack([np.full((count, 1), -1.0), np.eye(count)])
    dense = np.vstack([dense, np.eye(count + 1)[count] - np.eye(count + 1)[1]])
    made = sparse(dense).factored()
    assert made.rank == count
    assert made.dependency(count).equations.tolist() == [0, count - 1]


def test_a_factor_is_the_same_each_time() -> None:
    matrix = sparse(np.random.default_rng(3).normal(size=(30, 40)))
    one, other = matrix.factored(), matrix.analysed()
    other.factor(np.ones(len(matrix.entries)))
    other.factor(matrix.entries)
    assert np.array_equal(one.null_vectors().values, other.null_vectors().values)


@pytest.mark.parametrize("power", [-250, -20, 20, 250])
def test_the_size_of_all_entries_does_not_matter(power: int) -> None:
    dense = np.random.default_rng(2).integers(-3, 4, (8, 9)).astype(float)
    dense[5] = dense[1] + 2 * dense[3]
    one, other = sparse(dense).factored(), sparse(dense * 2.0**power).factored()
    assert other.rank == one.rank == 7
    assert other.gap == one.gap
    assert other.dependent.tolist() == [5]
    assert other.dependency(5).factors == pytest.approx([1.0, 2.0])


def test_the_rank_of_an_ill_conditioned_matrix_is_doubtful() -> None:
    i = np.arange(12)
    hilbert = 1.0 / (1 + i + i[:, None])
    made = sparse(hilbert).factored(np.ones(12))
    values = np.linalg.svd(made.scales[0][:, None] * hilbert, compute_uv=False)
    assert made.threshold == pytest.approx(1.07e-13, rel=0.6)
    near = np.sum(values > 100 * made.threshold), np.sum(values > made.threshold / 100)
    assert near[0] <= made.rank <= near[1] < 12
    assert made.gap < 1e4
