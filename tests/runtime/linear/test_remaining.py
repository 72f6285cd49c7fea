"""Solvers for some of the independent parts of a system."""

from __future__ import annotations

import numpy as np
import pytest

from arael.runtime.assembly.components import Partition
from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.evaluation.compiled import rows_of
from arael.runtime.linear.auto import make_solver
from arael.runtime.linear.narrowing import remaining_solver

# Three components, interleaved: a chain of 0, 2, 5, a pair of 1 and 4, and 3 alone.
SIZES = np.array([2, 1, 3, 2, 1, 2])
LABELS = np.array([0, 1, 0, 2, 1, 0], dtype=np.int32)
PATTERN = BlockPattern.from_pairs(SIZES, np.array([2, 5, 4]), np.array([0, 2, 1]))


def partition() -> Partition:
    none = np.zeros(0, dtype=np.int64)
    return Partition(
        3, LABELS, np.repeat(LABELS, SIZES), (), np.zeros(3, dtype=bool), none, none, none
    )


def system(seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Values of a positive definite matrix, its diagonal, and the whole matrix."""
    rng = np.random.default_rng(seed)
    matrix = np.zeros((PATTERN.size, PATTERN.size))
    values = np.zeros(PATTERN.value_count)
    at = PATTERN.offsets
    for column in range(len(SIZES)):
        for k in range(PATTERN.column_start[column], PATTERN.column_start[column + 1]):
            row = PATTERN.rows[k]
            block = rng.normal(size=(SIZES[row], SIZES[column]))
            block = block + block.T + 20 * np.eye(len(block)) if row == column else block
            values[PATTERN.value_start[k] :][: block.size] = block.ravel()
            matrix[at[row] : at[row + 1], at[column] : at[column + 1]] = block
            matrix[at[column] : at[column + 1], at[row] : at[row + 1]] = block.T
    return values, np.diag(matrix).copy(), matrix


@pytest.mark.parametrize("single", [False, True])
@pytest.mark.parametrize("name", ["dense", "band", "sparse", "schur"])
@pytest.mark.parametrize("chosen", [[0], [1], [2], [0, 2], [1, 2], [0, 1, 2]])
def test_the_part_is_solved_and_the_rest_stays(name: str, single: bool, chosen: list[int]) -> None:
    whole = make_solver(name, PATTERN, single)
    kept = np.isin(np.arange(3), chosen)
    part = remaining_solver(whole, partition(), kept)
    values, diagonal, matrix = system(1)
    scalars = kept[partition().of_scalar]
    assert part.inner.n == scalars.sum()
    # What is left out may be anything.
    diagonal[~scalars] = np.nan
    b = np.random.default_rng(2).normal(size=PATTERN.size)
    status, x = part.step(values, diagonal, b)
    assert status == 0
    expected = b.copy()
    expected[scalars] = np.linalg.solve(matrix[np.ix_(scalars, scalars)], b[scalars])
    np.testing.assert_allclose(x, expected, rtol=1e-5 if single else 1e-12)
    assert part.factorise(values, diagonal) == 0
    np.testing.assert_allclose(part.solved(b), expected, rtol=1e-5 if single else 1e-12)


@pytest.mark.parametrize("scalar", [1, 4, 5, 9, 10])
def test_a_pivot_is_named_in_the_whole(scalar: int) -> None:
    part = remaining_solver(
        make_solver("dense", PATTERN), partition(), np.array([True, False, False])
    )
    values, diagonal, _ = system(3)
    diagonal[scalar] = -1
    assert part.factorise(values, diagonal) == 1 + scalar


def test_rows_that_are_close_are_one_run() -> None:
    kept = np.array([0, 1, 1, 0, 1, 0, 0, 0, 1], dtype=bool)
    assert rows_of(kept, 0).tolist() == [[1, 3], [4, 5], [8, 9]]
    assert rows_of(kept, 1).tolist() == [[1, 5], [8, 9]]
    assert rows_of(kept, 3).tolist() == [[1, 9]]
    assert rows_of(~kept | kept, 3).tolist() == [[0, 9]]
    assert rows_of(kept & ~kept, 3).tolist() == []
