"""Proofs of independence from a few rows: they are right, and found where it matters."""

from __future__ import annotations

import numpy as np
import pytest

from arael.runtime.levels.compiled import PythonRows, surely_independent


def linear(matrix: np.ndarray) -> PythonRows:
    """Rows whose Jacobian is a matrix."""
    m, n = matrix.shape
    pattern = [np.flatnonzero(row) for row in matrix]
    return PythonRows(lambda x: matrix @ x, lambda x: matrix, n=n, m=m, pattern=pattern)


def proven(matrix: np.ndarray, asked: list[int], **more: object) -> bool:
    m, n = matrix.shape
    return surely_independent(linear(matrix), np.zeros(n), asked, np.ones(m, dtype=bool), **more)


def rank_without(matrix: np.ndarray, asked: list[int]) -> int:
    length = np.linalg.norm(matrix, axis=1, keepdims=True)
    matrix = matrix / np.where(length > 0.0, length, 1.0)
    rest = np.delete(matrix, asked, axis=0)
    return int(np.linalg.matrix_rank(matrix)) - int(np.linalg.matrix_rank(rest))


@pytest.mark.parametrize("seed", range(60))
def test_what_is_proven_is_independent(seed: int):
    random = np.random.default_rng(seed)
    m, n = random.integers(3, 30, 2)
    matrix = np.zeros((m, n))
    for row in matrix:
        some = random.choice(n, min(n, int(random.integers(1, 4))), replace=False)
        row[some] = random.choice([-1.0, 1.0, 2.0, 1e-12], len(some))
    for row in range(m):
        if proven(matrix, [row]):
            assert rank_without(matrix, [row]) == 1
    if proven(matrix, [0, 1]):
        assert rank_without(matrix, [0, 1]) == 2


def test_a_row_with_an_unknown_of_its_own_is_proven_beside_a_determined_part():
    # A chain of differences from a fixed first unknown, then a new row to a free unknown.
    count = 200
    matrix = np.zeros((count + 1, count + 1))
    matrix[0, 0] = 1.0
    for k in range(1, count):
        matrix[k, k - 1], matrix[k, k] = -1.0, 1.0
    matrix[count, count - 1], matrix[count, count] = -1.0, 1.0
    assert proven(matrix, [count])
    # The same between unknowns that are determined follows from others.
    matrix[count] = 0.0
    matrix[count, 0], matrix[count, count - 1] = -1.0, 1.0
    assert not proven(matrix, [count])


def test_rows_that_depend_on_each_other_alone_are_not_proven():
    matrix = np.array([[1.0, 1.0, 0.0], [2.0, 2.0, 0.0], [0.0, 0.0, 1.0]])
    assert not proven(matrix, [0, 1])
    assert proven(matrix, [2])


def test_a_remainder_of_rounding_proves_nothing():
    matrix = np.array([[1.0, 1.0], [1.0, 1.0 + 1e-12]])
    assert not proven(matrix, [1])


def test_rows_that_are_no_equations_do_not_count():
    matrix = np.array([[1.0, 0.0], [1.0, 0.0]])
    rows, x = linear(matrix), np.zeros(2)
    assert not surely_independent(rows, x, [1], np.array([True, True]))
    assert surely_independent(rows, x, [1], np.array([False, True]))


def test_rows_that_the_system_does_not_have():
    matrix = np.array([[1.0, -1.0, 0.0, 0.0]])
    assert proven(matrix, [], more=[([1, 2], [1.0, -1.0]), ([3], [1.0])])
    assert not proven(matrix, [], more=[([0, 1], [1.0, -1.0])])
    assert not proven(matrix, [], more=[([2, 3], [1.0, -1.0]), ([2, 3], [2.0, -2.0])])


def test_scales_are_those_of_the_unknowns():
    matrix = np.array([[1.0, 1e-6], [1.0, 0.0]])
    assert not proven(matrix, [0])
    assert proven(matrix, [0], scales=np.array([1.0, 1e6]))


def test_a_row_of_rounding_proves_nothing():
    assert not proven(np.array([[1e-9, 0.0], [0.0, 1.0]]), [0])


def test_a_row_without_unknowns_proves_nothing():
    assert not proven(np.array([[0.0, 0.0], [1.0, 0.0]]), [0])
    assert not proven(np.zeros((0, 2)), [])
