"""Offsets of single scalars in the values of a block matrix, and lane order, on random shapes."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.assembly.positions import (
    coordinates,
    dense_matrix,
    diagonal_positions,
    row_and_column_positions,
)
from arael.runtime.evaluation.instances import in_lanes

PROFILE = settings(max_examples=40, deadline=None)


@st.composite
def patterns(draw):
    sizes = np.array(draw(st.lists(st.integers(1, 4), min_size=1, max_size=6)))
    block = st.integers(0, len(sizes) - 1)
    pairs = draw(st.lists(st.tuples(block, block), max_size=8))
    rows = np.array([p[0] for p in pairs], dtype=np.int64)
    columns = np.array([p[1] for p in pairs], dtype=np.int64)
    return BlockPattern.from_pairs(sizes, rows, columns)


def by_hand(pattern) -> dict[tuple[int, int], int]:
    """Scalar row and column -> offset, block by block."""
    found = {}
    offsets = pattern.offsets
    for j in range(pattern.block_count):
        for k in range(pattern.column_start[j], pattern.column_start[j + 1]):
            i = pattern.rows[k]
            for r in range(pattern.sizes[i]):
                for c in range(pattern.sizes[j]):
                    at = pattern.value_start[k] + r * pattern.sizes[j] + c
                    found[int(offsets[i] + r), int(offsets[j] + c)] = int(at)
    return found


@PROFILE
@given(patterns())
def test_coordinates_and_diagonal(pattern):
    expected = by_hand(pattern)
    row, column = coordinates(pattern)
    assert {
        (int(r), int(c)): k for k, (r, c) in enumerate(zip(row, column, strict=True))
    } == expected
    at = diagonal_positions(pattern)
    assert at.tolist() == [expected[i, i] for i in range(pattern.size)]


@PROFILE
@given(patterns(), st.data())
def test_rows_and_columns_of_chosen_scalars(pattern, data):
    chosen = data.draw(st.sets(st.integers(0, pattern.size - 1)))
    scalars = np.array(sorted(chosen), dtype=np.int64)
    start, positions = row_and_column_positions(pattern, scalars)
    expected = by_hand(pattern)
    for k, scalar in enumerate(scalars):
        mine = {p for (r, c), p in expected.items() if (r == scalar) != (c == scalar)}
        assert set(positions[start[k] : start[k + 1]].tolist()) == mine


@PROFILE
@given(patterns())
def test_dense_matrix_is_symmetric_and_ignores_upper_triangles(pattern):
    values = np.arange(1.0, pattern.value_count + 1)
    found = dense_matrix(pattern, values)
    np.testing.assert_array_equal(found, found.T)
    for (r, c), at in by_hand(pattern).items():
        if r >= c:
            assert found[r, c] == values[at]


@PROFILE
@given(st.integers(0, 20), st.integers(0, 3), st.sampled_from([1, 4, 8]))
def test_lane_order_pads_with_the_last_instance(n, k, lanes):
    values = np.arange(n * k, dtype=float).reshape(n, k)
    found = in_lanes(values, lanes)
    assert found.shape == (-(-n // lanes), k, lanes) and found.flags.c_contiguous
    for block in range(len(found)):
        for w in range(lanes):
            source = values[min(block * lanes + w, n - 1)]
            np.testing.assert_array_equal(found[block, :, w], source)
