"""Flags of rows: where all hold, and the scalars that they stand for."""

from __future__ import annotations

import numpy as np
import pytest

from arael.runtime.store.compiled import all_set, rows_where, spread_flags


def test_rows_have_all_required_flags_and_none_refused() -> None:
    here = np.array([True, True, False, True])
    moves = np.array([True, False, True, True])
    fixed = np.array([False, False, False, True])
    np.testing.assert_array_equal(
        rows_where(4, [here, moves], [fixed]), [True, False, False, False]
    )
    np.testing.assert_array_equal(rows_where(2, [], []), [True, True])
    with pytest.raises(ValueError, match="at least 5"):
        rows_where(5, [here], [])
    with pytest.raises(TypeError, match="bool"):
        rows_where(4, [here.astype(np.int8)], [])


def test_flags_are_spread_over_the_scalars_of_a_parameter() -> None:
    scalars = np.zeros((2, 4), dtype=bool)
    spread_flags(np.array([True, False]), scalars, 1, 2)
    np.testing.assert_array_equal(scalars, [[False, True, True, False], [False] * 4])
    with pytest.raises(IndexError, match="columns 3 to 5 of 4"):
        spread_flags(np.array([True, False]), scalars, 3, 2)


def test_of_no_flags_not_all_are_set() -> None:
    assert all_set(np.ones((2, 3), dtype=bool))
    assert not all_set(np.array([[True, False]]))
    assert not all_set(np.zeros((0, 3), dtype=bool))
