"""Selected entries of the inverse against the dense inverse."""

from __future__ import annotations

import numpy as np
import pytest

from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.linear.compiled import SparseSolver
from arael.runtime.linear.selected import SelectedInverse
from tests.runtime.linear import block_matrices as bm

PATTERNS = {
    "chain": bm.chain(30, 3),
    "arrow": bm.arrow(12, 2),
    "grid": bm.grid(9, 7, 3),
    "slam": bm.slam(12, 40),
    "mixed sizes": bm.build([1, 4, 2, 6, 3], [(0, 3), (1, 3), (2, 4), (3, 4)]),
    "apart": bm.build([3, 3, 2], [(0, 1)]),
    "one": bm.build([5], []),
}


@pytest.mark.sweep(4)
@pytest.mark.parametrize("ordering", ["auto", "natural", "minimum_degree", "nested_dissection"])
@pytest.mark.parametrize("name", PATTERNS)
def test_blocks_against_the_dense_inverse(name: str, ordering: str) -> None:
    pattern: BlockPattern = PATTERNS[name]
    values, diagonal = bm.positive(pattern, seed=3)
    solver = SparseSolver(pattern, ordering=ordering)
    assert solver.factorise(values, diagonal) == 0
    found = SelectedInverse(solver)
    inverse = np.linalg.inv(bm.dense(pattern, values, diagonal))
    np.testing.assert_allclose(found.diagonal(), np.diag(inverse), rtol=1e-9)
    offset = pattern.offsets
    spans = [np.arange(offset[i], offset[i + 1]) for i in range(pattern.block_count)]
    for j in range(pattern.block_count):
        for i in pattern.rows[pattern.column_start[j] : pattern.column_start[j + 1]]:
            block = found.block(spans[i], spans[j])
            assert block is not None
            expected = inverse[np.ix_(spans[i], spans[j])]
            np.testing.assert_allclose(block, expected, rtol=1e-8, atol=1e-12)
    size = int(pattern.sizes[0])
    same = [i for i in range(pattern.block_count) if pattern.sizes[i] == size]
    squares = found.diagonal_blocks(offset[same], size)
    for square, i in zip(squares, same, strict=True):
        np.testing.assert_allclose(square, inverse[np.ix_(spans[i], spans[i])], rtol=1e-8)


def test_what_the_factor_lacks_is_not_made_up() -> None:
    pattern = bm.chain(40, 3)
    values, diagonal = bm.positive(pattern, seed=1)
    solver = SparseSolver(pattern, ordering="natural")
    assert solver.factorise(values, diagonal) == 0
    assert SelectedInverse(solver).block(np.array([0]), np.array([119])) is None
