"""Columns by instance and rows in lanes, against NumPy."""

from __future__ import annotations

import numpy as np
import pytest

from arael.runtime.store.compiled import (
    followed,
    join_columns,
    numbered,
    solved_scalars,
    split_columns,
    spread_all,
    spread_rows,
    taken,
)


@pytest.mark.parametrize("dtype", [np.float64, np.float32, np.int64, np.bool_])
def test_components_of_some_rows_are_taken_as_f64(dtype: type) -> None:
    rng = np.random.default_rng(1)
    values = rng.integers(0, 2, (7, 3)).astype(dtype)
    rows = rng.integers(0, 7, 20)
    found = taken(values, [2, 0], rows)
    assert found.dtype == np.float64
    np.testing.assert_array_equal(found, values[rows][:, [2, 0]].T.astype(np.float64))
    assert taken(values, [0], rows[:0]).shape == (1, 0)
    assert taken(values, [], rows).shape == (0, 20)


def test_rows_and_components_that_are_not_there_are_refused() -> None:
    values = np.zeros((2, 3))
    with pytest.raises(IndexError, match="row 2 of 2"):
        taken(values, [0], np.array([0, 2]))
    with pytest.raises(IndexError, match="row -1 of 2"):
        taken(values, [0], np.array([-1]))
    with pytest.raises(IndexError, match="component 3 of 3"):
        taken(values, [3], np.array([0]))
    with pytest.raises(TypeError, match="expected numbers"):
        taken(values.astype(np.complex128), [0], np.array([0]))


@pytest.mark.parametrize("dtype", [np.float64, np.float32, np.int64, np.int32, np.uint8])
@pytest.mark.parametrize("n", [1, 7, 8, 9, 24])
def test_rows_are_spread_over_lanes_and_the_last_one_pads(dtype: type, n: int) -> None:
    rng = np.random.default_rng(n)
    values = rng.integers(0, 100, (n, 3)).astype(dtype)
    order = rng.permutation(n)
    for chosen in (None, order):
        found = spread_rows(values, 8, chosen)
        assert found.shape == (-(-n // 8), 3, 8) and found.dtype == dtype
        np.testing.assert_array_equal(spread_rows(np.asfortranarray(values), 8, chosen), found)
        at = np.minimum(np.arange(8 * len(found)), n - 1)
        expected = (values if chosen is None else values[order])[at]
        np.testing.assert_array_equal(found.transpose(0, 2, 1).reshape(-1, 3), expected)


@pytest.mark.parametrize("n", [0, 1, 8, 21])
def test_several_arrays_are_spread_into_one_piece_of_memory(n: int) -> None:
    rng = np.random.default_rng(n)
    arrays = [
        rng.integers(0, 100, (n, k)).astype(dtype)
        for k, dtype in ((2, np.int32), (3, np.int64), (0, np.int64), (3, np.uint8))
    ]
    for order in (None, rng.permutation(n)):
        for array, found in zip(arrays, spread_all(arrays, 8, order), strict=True):
            np.testing.assert_array_equal(found, spread_rows(array, 8, order))
            assert found.dtype == array.dtype and not found.flags.writeable
            assert not found.size or found.ctypes.data % 64 == 0
    with pytest.raises(ValueError, match="expected 2 rows, found 3"):
        spread_all([np.zeros((2, 1)), np.zeros((3, 1))], 8)


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_columns_become_rows_and_go_back_where_something_moves(dtype: type) -> None:
    rng = np.random.default_rng(3)
    columns = [rng.normal(size=shape).astype(dtype) for shape in ((5,), (5, 3), (5, 2, 2))]
    rows = np.full((5, 9), 7, dtype)
    join_columns(columns, [5, 1, 5], rows[:, :])  # the last covers the first
    np.testing.assert_array_equal(rows[:, 1:4], columns[1])
    np.testing.assert_array_equal(rows[:, 5:9], columns[2].reshape(5, 4))
    np.testing.assert_array_equal(rows[:, [0, 4]], 7)
    state = rng.normal(size=(6, 9)).astype(dtype)
    free = rng.integers(0, 2, (5, 4)).astype(bool)
    free[0] = [False, False, True, False]
    for flags in (None, free):
        found = [column.copy() for column in columns]
        split_columns(state, [0, 1, 5], found, flags, [0, 1, 0], [1, 3, 0])
        for k, (first, count) in enumerate(((0, 1), (1, 3))):
            moved = (
                np.ones(5, bool) if flags is None else flags[:, first : first + count].any(axis=1)
            )
            width = columns[k].reshape(5, -1).shape[1]
            expected = columns[k].copy().reshape(5, width)
            expected[moved] = state[:5, [0, 1][k] : [0, 1][k] + width][moved]
            np.testing.assert_array_equal(found[k].reshape(5, width), expected)
        np.testing.assert_array_equal(found[2], columns[2])  # nothing moves it
    kept = [solved_scalars([state, state], [free, flags], [2, 3]) for flags in (free, ~free)]
    for one, flags in zip(kept, (free, ~free), strict=True):
        expected = np.concatenate(
            [state[:5][free.any(axis=1), :2].ravel(), state[:5][flags.any(axis=1), :3].ravel()]
        )
        np.testing.assert_array_equal(one, expected.astype(np.float64))


def test_columns_of_another_precision_keep_what_does_not_move() -> None:
    column, rows = np.array([1 + 1e-12, 2.0]), np.zeros((2, 2), np.float32)
    join_columns([column], [1], rows)
    np.testing.assert_array_equal(rows, [[0, 1], [0, 2]])
    free = np.array([[False], [True]])
    split_columns(rows + np.float32(0.5), [1], [column], free, [0], [1])
    np.testing.assert_array_equal(column, [1 + 1e-12, 2.5])


def test_columns_without_rows() -> None:
    empty = np.zeros((0, 3))
    join_columns([np.zeros(0), np.zeros((0, 2))], [0, 1], empty)
    split_columns(empty, [0, 1], [np.zeros(0), np.zeros((0, 2))], None, [0, 1], [1, 2])
    assert solved_scalars([empty], [np.zeros((0, 3), bool)], [3]).shape == (0,)


def test_columns_that_do_not_fit_are_refused() -> None:
    rows, column = np.zeros((2, 3)), np.zeros((2, 2))
    with pytest.raises(IndexError, match="columns 2 and 2 more of 3"):
        join_columns([column], [2], rows)
    with pytest.raises(ValueError, match="expected 2 rows"):
        join_columns([np.zeros((1, 2))], [0], rows)
    with pytest.raises(IndexError, match="scalars 2 and 2 more of 3"):
        split_columns(rows, [2], [column], None, [0], [1])
    with pytest.raises(IndexError, match="flags 1 and 2 more of 2"):
        split_columns(rows, [0], [column], np.ones((2, 2), bool), [1], [2])
    with pytest.raises(IndexError, match="2 rows of 4"):
        solved_scalars([rows], [np.ones((2, 2), bool)], [4])


def test_an_order_of_other_instances_is_refused() -> None:
    with pytest.raises(IndexError, match="not there"):
        spread_rows(np.zeros((2, 1)), 8, np.array([0, 2]))


def test_rows_are_followed_and_what_is_absent_stays_absent() -> None:
    targets = np.array([5, 6, -1])
    np.testing.assert_array_equal(followed(targets, np.array([2, -1, 0, 1])), [-1, -1, 5, 6])
    assert followed(targets, np.zeros(0, np.int64)).shape == (0,)
    np.testing.assert_array_equal(followed(targets[:0], np.array([-1, -1])), [-1, -1])
    with pytest.raises(IndexError, match="row 3 of 3"):
        followed(targets, np.array([3]))


@pytest.mark.parametrize("share", [0.0, 0.3, 0.9, 1.0])
@pytest.mark.parametrize("shape", [(0, 3), (1, 1), (17, 3), (5, 0)])
def test_rows_in_which_something_moves_are_numbered(share: float, shape: tuple[int, int]) -> None:
    rng = np.random.default_rng(3)
    tables = [rng.random(shape) < share, np.ones((2, 2), dtype=bool), rng.random(shape) < share]
    rows, sizes, held, starts, size = numbered(tables)
    block = scalar = 0
    still = []
    for flags, (first, number, every), start in zip(tables, rows, starts, strict=True):
        moving = np.flatnonzero(flags.any(axis=1))
        assert start == scalar and every == (flags.size > 0 and flags.all())
        expected = np.full(len(flags), -1)
        expected[moving] = block + np.arange(len(moving))
        np.testing.assert_array_equal(number, expected)
        expected[moving] = scalar + flags.shape[1] * np.arange(len(moving))
        np.testing.assert_array_equal(first, expected)
        np.testing.assert_array_equal(sizes[block : block + len(moving)], flags.shape[1])
        still.append(scalar + np.flatnonzero(~flags[moving].ravel()))
        block, scalar = block + len(moving), scalar + flags[moving].size
    assert (len(sizes), size) == (block, scalar)
    np.testing.assert_array_equal(held, np.concatenate(still))
