"""Reduction of dependencies by priority, apart from a factorisation."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from arael.runtime.orthogonal.exchange import reduce_by_priority

Rows = list[tuple[NDArray[np.int32], NDArray[np.float64]]]


def rows_of(dense: NDArray[np.float64]) -> Rows:
    return [(np.flatnonzero(row).astype(np.int32), row[row != 0]) for row in dense]


@pytest.mark.parametrize("seed", range(8))
def test_the_first_columns_that_are_independent_are_pivots(seed: int) -> None:
    rng = np.random.default_rng(seed)
    dense = (rng.integers(-2, 3, (6, 15)) * (rng.random((6, 15)) < 0.4)).astype(float)
    kept: list[int] = []
    for k in range(6):
        if np.linalg.matrix_rank(dense[[*kept, k]]) > len(kept):
            kept.append(k)
    dense = dense[kept]
    made = reduce_by_priority(rows_of(dense), 15, 1e-9)
    expected: list[int] = []
    for c in range(15):
        if np.linalg.matrix_rank(dense[:, [*expected, c]]) > len(expected):
            expected.append(c)
    assert sorted(pivot for pivot, _, _ in made) == expected
    result = np.zeros((len(made), 15))
    for k, (_, at, row) in enumerate(made):
        result[k, at] = row
    pivots = [pivot for pivot, _, _ in made]
    assert np.array_equal(result[:, pivots], -np.eye(len(made)))
    assert np.linalg.matrix_rank(np.vstack([dense, result])) == len(dense)


def test_a_row_of_which_only_small_entries_remain_keeps_a_pivot() -> None:
    dense = np.array([[1e12, 1.0, 0.0], [1e12, 0.0, 1.0]])
    made = reduce_by_priority(rows_of(dense), 3, 1e-8)
    assert len(made) == 2
    assert made[-1][0] == 0
    pivot, at, row = made[0]
    assert pivot in (1, 2)
    assert dict(zip(at.tolist(), row.tolist(), strict=True)) == {
        1: pytest.approx(row[0]),
        2: pytest.approx(-row[0]),
    }


@pytest.mark.parametrize("seed", range(8))
def test_dependencies_that_agree_but_for_rounding_in_what_is_least_important(seed: int) -> None:
    """The same numbers by another factor at the first equations, with a small first one.

    What is left of their differences is rounding, enlarged by the small pivot; it is no pivot.
    """
    rng = np.random.default_rng(seed)
    shared = np.append(2e-6, rng.standard_normal(10))
    table = []
    for factor in (0.1, 0.3, 1.1, 2.7):
        rounded = factor * shared * (1 + 1e-13 * rng.standard_normal(11))
        own = rng.choice(np.arange(11, 35), 8, replace=False)
        places = np.append(np.arange(11), np.sort(own)).astype(np.int32)
        table.append((places, np.append(rounded, rng.uniform(0.5, 1.5, 8))))
    whole = np.zeros((4, 35))
    for row, (places, numbers) in zip(whole, table, strict=True):
        row[places] = numbers
    found = reduce_by_priority(table, 35, 1e-8)
    assert len(found) == 4
    for pivot, places, numbers in found:
        row = np.zeros(35)
        row[places] = numbers
        assert row[pivot] == -1.0
        left = row - np.linalg.lstsq(whole.T, row, rcond=None)[0] @ whole
        assert np.abs(left).max() <= 1e-9 * np.abs(row).max()


def test_dependencies_that_follow_from_others_are_left_out() -> None:
    places = np.arange(2, dtype=np.int32)
    table = [(places, np.array([1.0, 1.0])), (places, np.array([1.0, -1.0]))]
    table.append((places, np.array([0.5, 0.25])))
    assert len(reduce_by_priority(table, 2, 1e-8)) == 2
