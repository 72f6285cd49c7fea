"""The order of instances by their lead, against the same by NumPy."""

from __future__ import annotations

import numpy as np
import pytest

from arael.runtime.assembly.compiled import keys_of, order_by, shared_rows


@pytest.mark.parametrize("seed", range(8))
def test_instances_are_ordered_by_lead_and_those_that_meet_again_come_last(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n, nowhere = int(rng.integers(1, 40)), 10
    rows = rng.integers(0, 5, (n, 2)).astype(np.int32)
    block_at = rng.integers(0, nowhere + 1, (n, 3))
    block_at[:, 0] = nowhere  # solved for nowhere: the next pair decides
    keys = keys_of(rows, 1, block_at, [0, 2], nowhere)
    met = [
        at != nowhere and bool((block_at[:k, 2] == at).any()) for k, at in enumerate(block_at[:, 2])
    ]
    np.testing.assert_array_equal(keys, 2 * rows[:, 1] + np.array(met, dtype=int))
    order = order_by(keys)
    expected = np.argsort(keys, kind="stable")
    np.testing.assert_array_equal(np.arange(n) if order is None else order, expected)


def test_negative_keys_are_ordered_too() -> None:
    """They would be counted before the first place."""
    np.testing.assert_array_equal(order_by(np.array([1, -2, 0, -2])), [1, 3, 2, 0])


def test_places_of_fewer_instances_are_refused() -> None:
    rows, block_at = np.zeros((3, 2), dtype=np.int32), np.zeros((2, 3), dtype=np.int64)
    with pytest.raises(ValueError, match="at least 9 scalars"):
        keys_of(rows, 0, block_at, [1], 0)


def test_keys_that_are_far_apart_are_ordered_too() -> None:
    np.testing.assert_array_equal(order_by(np.array([10**9, 3, 10**9, 0])), [3, 1, 0, 2])
    assert order_by(np.array([0, 0, 10**9])) is None
    assert order_by(np.zeros(0, dtype=np.int64)) is None


def test_places_and_uses_that_are_not_there_are_refused() -> None:
    rows, block_at = np.zeros((2, 2), dtype=np.int32), np.zeros((2, 3), dtype=np.int64)
    with pytest.raises(IndexError, match="use 2 of 2"):
        keys_of(rows, 2, block_at, [1], 0)
    with pytest.raises(IndexError, match="pair 3 of 3"):
        keys_of(rows, 0, block_at, [3], 0)
    with pytest.raises(IndexError, match="place 7 of 6"):
        keys_of(rows, 0, block_at + 7, [1], 6)
    with pytest.raises(IndexError, match="use 2 of 2"):
        shared_rows(np.zeros((1, 2, 2), dtype=np.int32), [2], 2)


def test_blocks_share_rows_of_all_leads_and_a_padded_one_never() -> None:
    rows = np.zeros((3, 2, 4), dtype=np.int32)
    rows[1, 1, 3] = 1
    np.testing.assert_array_equal(shared_rows(rows, [0, 1], 12), [1, 0, 1])
    np.testing.assert_array_equal(shared_rows(rows, [0], 11), [1, 1, 0])
    np.testing.assert_array_equal(shared_rows(rows, [], 12), [0, 0, 0])
