"""Rows of handles: live, null and stale ones."""

from __future__ import annotations

import numpy as np
import pytest

from arael.runtime.store.compiled import rows_of_handles


def test_rows_are_those_of_live_slots() -> None:
    positions, generations = np.array([7, -1, 5]), np.array([0, 0, 3])
    handles = np.array([0, -1, 1, 2, (3 << 32) | 2, (1 << 32), 3])
    found = rows_of_handles(handles, positions, generations, 5, 32)
    np.testing.assert_array_equal(found, [2, -1, -1, -1, 0, -1, -1])


def test_generations_are_as_many_as_positions() -> None:
    with pytest.raises(ValueError, match="at least 2"):
        rows_of_handles(np.zeros(1, np.int64), np.zeros(2, np.int64), np.zeros(1, np.int64), 0, 32)
