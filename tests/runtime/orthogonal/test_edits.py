"""Equations appended, dropped and put back."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.runtime.orthogonal.matrices import Doubles, integer_matrices, sparse


@settings(max_examples=60, deadline=None)
@given(integer_matrices(), st.lists(st.integers(0, 9), min_size=1, max_size=12))
def test_a_dropped_equation_takes_no_part(dense: Doubles, edits: list[int]) -> None:
    m = len(dense)
    made = sparse(dense)
    factor = made.factored()
    active = np.ones(m, dtype=bool)
    for i in edits:
        if i >= m:
            continue
        (factor.drop if active[i] else factor.restore)(i)
        active[i] = not active[i]
        fresh = made.analysed()
        fresh.factor(made.entries, factor.scales[1], active)
        assert factor.rank == fresh.rank
        assert factor.dependent.tolist() == fresh.dependent.tolist()
        # The fronts that were not factored again are those that would not have changed.
        assert np.array_equal(factor.null_vectors().dense(), fresh.null_vectors().dense())
        assert np.array_equal(factor.independent, fresh.independent)


@settings(max_examples=60, deadline=None)
@given(integer_matrices(), integer_matrices(3, 10))
def test_an_appended_equation_is_judged_and_then_takes_part(dense: Doubles, rows: Doubles) -> None:
    n = dense.shape[1]
    factor = sparse(dense).factored()
    for row in rows:
        new = np.zeros(n)
        new[: min(n, len(row))] = row[:n]
        before, at = factor.rank, np.flatnonzero(new)
        found = factor.append(at, new[at])
        dense = np.vstack([dense, new])
        assert factor.m == len(dense)
        assert factor.rank == (np.linalg.matrix_rank(dense) if dense.size else 0)
        assert (found.remainder > factor.tolerance) == (factor.rank > before)
        if factor.rank == before:
            assert found.factors @ dense[found.equations] == pytest.approx(new, abs=1e-9)


def test_appended_equations_have_a_priority() -> None:
    factor = sparse(np.array([[1.0, 1.0]])).factored()
    factor.append([0, 1], [2.0, 2.0], priority=-1)
    assert factor.dependent.tolist() == [0]
    assert factor.dependency(0).factors == pytest.approx([0.5])


def test_given_scales_and_dropped_equations_survive_an_append() -> None:
    factor = sparse(np.eye(3)).factored(np.array([1.0, 4.0, 16.0]))
    factor.drop(1)
    factor.append([1, 2], [1.0, 1.0])
    assert factor.rank == 3
    assert factor.scales[1].tolist() == [1.0, 4.0, 16.0]
    factor.restore(1)
    assert factor.dependent.tolist() == [3]


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (lambda q: q.drop(2), "expected an equation from 0 to 1, found 2"),
        (lambda q: q.restore(0), "equation 0 is active already"),
        (lambda q: (q.drop(0), q.drop(0)), "equation 0 is dropped already"),
        (lambda q: q.append([5], [1.0]), r"expected unknowns from 0 to 1, found \[5\]"),
        (lambda q: q.append([0], [np.nan]), "the row has an entry that is not finite"),
    ],
)
def test_edits_that_cannot_be(edit: object, message: str) -> None:
    factor = sparse(np.eye(2)).factored()
    with pytest.raises(ValueError, match=message):
        edit(factor)  # type: ignore[operator]
    assert factor.m == 2


def test_an_equation_that_is_not_finite_is_not_restored() -> None:
    made = sparse(np.eye(2))
    factor = made.analysed()
    factor.factor([1.0, np.inf], active=[True, False])
    assert factor.rank == 1
    with pytest.raises(ValueError, match="equation 1 has an entry that is not finite"):
        factor.restore(1)
    assert factor.rank == 1
