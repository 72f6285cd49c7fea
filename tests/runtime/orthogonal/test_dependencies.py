"""Dependencies: which equations, with which factors, and what remains."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.runtime.orthogonal.matrices import Doubles, grid, integer_matrices, sparse


@settings(max_examples=100, deadline=None)
@given(integer_matrices(), st.integers(0, 2**32))
def test_combinations_of_equations_are_found(dense: Doubles, seed: int) -> None:
    m, n = dense.shape
    made = sparse(dense).factored()
    row = np.random.default_rng(seed).integers(-3, 4, m) @ dense
    found = made.dependency_of(np.arange(n), row)
    assert found.remainder < 1e-12
    assert found.factors @ dense[found.equations] == pytest.approx(row, abs=1e-9)
    assert not set(found.equations.tolist()) & set(made.dependent.tolist())
    # Independent equations have one combination only: that of the pseudoinverse.
    basis = dense[made.independent]
    expected = np.zeros(m)
    expected[made.independent] = np.linalg.lstsq(basis.T, row)[0] if basis.size else 0
    given_ = np.zeros(m)
    given_[found.equations] = found.factors
    assert given_ == pytest.approx(expected, abs=1e-7)


@settings(max_examples=100, deadline=None)
@given(integer_matrices(), st.integers(0, 2**32))
def test_the_remainder_is_the_distance_to_the_row_space(dense: Doubles, seed: int) -> None:
    n = dense.shape[1]
    made = sparse(dense).factored(np.ones(n))
    row = np.random.default_rng(seed).normal(size=n)
    found = made.dependency_of(np.arange(n), row)
    nearest = np.linalg.pinv(dense) @ dense @ row if dense.size else np.zeros(n)
    length = np.linalg.norm(row) or 1.0
    assert found.remainder == pytest.approx(np.linalg.norm(row - nearest) / length, abs=1e-12)
    assert found.factors @ dense[found.equations] == pytest.approx(nearest, abs=1e-9)


@settings(max_examples=100, deadline=None)
@given(integer_matrices(9, 7), st.integers(0, 2**32))
def test_dependencies_of_badly_scaled_equations(dense: Doubles, seed: int) -> None:
    rng = np.random.default_rng(seed)
    m, n = dense.shape
    scaled = dense * 10.0 ** rng.integers(-6, 7, n) * 10.0 ** rng.integers(-6, 7, (m, 1))
    made = sparse(scaled).factored()
    assert len(made.dependent) == m - made.rank
    for i in made.dependent.tolist():
        found = made.dependency(i)
        assert set(found.equations.tolist()) <= {*np.flatnonzero(made.independent).tolist()}
        terms = np.vstack([-scaled[i], found.factors[:, None] * scaled[found.equations]])
        assert np.all(np.abs(terms.sum(axis=0)) <= 1e-9 * (np.abs(terms).max(axis=0) + 1e-300))


@settings(max_examples=60, deadline=None)
@given(integer_matrices(8, 6), st.integers(0, 2**32))
def test_the_least_important_equations_are_dependent(dense: Doubles, seed: int) -> None:
    m = len(dense)
    priority = np.random.default_rng(seed).integers(0, 3, m)
    made = sparse(dense).analysed(priority=priority)
    made.factor(sparse(dense).entries)
    kept: list[int] = []
    for i in sorted(range(m), key=lambda i: (priority[i], i)):  # greedy, which is optimal
        if dense.size and np.linalg.matrix_rank(dense[[*kept, i]]) > len(kept):
            kept.append(i)
    assert sorted(kept) == np.flatnonzero(made.independent).tolist()


def test_members_of_a_dependency_and_no_others() -> None:
    # A square of four sides that are parallel in turn, and something beside it.
    dense = np.array([[1.0, -1, 0, 0, 0], [0, 1, -1, 0, 0], [0, 0, 0, 1, 1], [-1, 0, 1, 0, 0]])
    made = sparse(dense).factored()
    found = made.dependency(3)
    assert found.equations.tolist() == [0, 1]
    assert found.factors == pytest.approx([-1, -1])
    assert found.remainder < 1e-15


def test_an_equation_without_entries_depends_on_none() -> None:
    made = sparse(np.array([[0.0, 0], [1, 0]])).factored()
    assert made.dependent.tolist() == [0]
    assert made.dependency(0).equations.tolist() == []
    assert made.dependency_of([], []).remainder == 0


def test_the_dependency_of_an_independent_equation_is_refused() -> None:
    made = sparse(np.eye(2)).factored()
    with pytest.raises(ValueError, match="equation 1 is not a dependent one"):
        made.dependency(1)


def test_small_factors_are_kept_but_not_exchanged() -> None:
    # The last is the first and a little of the second, which is the least important.
    dense = np.array([[1.0, 0, 0], [0, 1, 0], [1, 1e-9, 0], [0, 1, 1], [0, 2, 2]])
    made = sparse(dense).analysed(priority=[0, 5, 0, 0, 0])
    made.factor(sparse(dense).entries, np.ones(3))
    assert made.dependent.tolist() == [2, 4]
    found = made.dependency(2)
    assert found.equations.tolist() == [0, 1]
    assert found.factors == pytest.approx([1, 1e-9], rel=1e-12)


def test_exchanges_of_a_grid_leave_the_tree_of_its_first_edges() -> None:
    made = grid(12)
    factor = made.factored()
    groups = list(range(made.n))  # points connected by the edges before
    later = []
    for i in range(made.m):
        one, other = (groups[u] for u in made.row(i)[0])
        if one == other:
            later.append(i)
        groups = [one if g == other else g for g in groups]
    assert factor.dependent.tolist() == later
    for i in later:
        found = factor.dependency(i)
        assert np.abs(found.factors) == pytest.approx(np.ones(len(found.factors)))
        assert not set(found.equations.tolist()) & set(later)
