"""Factors that are broken off: by a flag set before, or after a number of looks at it."""

from __future__ import annotations

import numpy as np
import pytest

from arael.runtime.compiled import InterruptedWork, Interruption
from arael.runtime.orthogonal import RankQR
from tests.runtime.orthogonal.matrices import Sparse, grid

GRID = grid(12)


def factored(matrix: Sparse, interruption: Interruption) -> RankQR:
    found = RankQR(matrix.m, matrix.n, matrix.indptr, matrix.indices, interruption=interruption)
    found.factor(matrix.entries)
    return found


def test_nothing_begins_after_a_request() -> None:
    interruption = Interruption()
    interruption.request()
    with pytest.raises(InterruptedWork):
        factored(GRID, interruption)
    interruption.withdraw()
    assert factored(GRID, interruption).rank == GRID.n - 1


def test_analysis_and_factor_end_wherever_they_are() -> None:
    right = factored(GRID, Interruption())
    interruption = Interruption()
    looks = 1
    while True:
        interruption.request(looks)
        try:
            found = factored(GRID, interruption)
            break
        except InterruptedWork:
            assert interruption.requested
            interruption.withdraw()
            looks += 1
    assert looks > 2 * GRID.m  # rows of the ordering, columns of the structure, pivots, fronts
    interruption.withdraw()
    np.testing.assert_array_equal(found.dependent, right.dependent)
    np.testing.assert_array_equal(found.null_vectors().values, right.null_vectors().values)


def test_a_factor_that_was_broken_off_is_none_and_is_made_again() -> None:
    interruption = Interruption()
    right, found = factored(GRID, Interruption()), factored(GRID, interruption)
    for looks in range(1, 20):
        interruption.request(looks)
        with pytest.raises(InterruptedWork):
            found.factor(GRID.entries)
        interruption.withdraw()
        assert not found.factored
        with pytest.raises(ValueError, match="no factor"):
            _ = found.rank
    found.factor(GRID.entries)
    np.testing.assert_array_equal(found.dependent, right.dependent)
    np.testing.assert_array_equal(found.null_vectors().values, right.null_vectors().values)


def test_dependencies_and_null_vectors_end_between_two() -> None:
    interruption = Interruption()
    right, found = factored(GRID, Interruption()), factored(GRID, interruption)
    interruption.request(3)
    with pytest.raises(InterruptedWork):
        _ = found.dependent
    interruption.withdraw()
    np.testing.assert_array_equal(found.dependent, right.dependent)
    equation = int(found.dependent[0])
    np.testing.assert_array_equal(
        found.dependency(equation).factors, right.dependency(equation).factors
    )
    interruption.request()
    with pytest.raises(InterruptedWork):
        found.null_vectors()
    interruption.withdraw()
    np.testing.assert_array_equal(found.null_vectors().values, right.null_vectors().values)
