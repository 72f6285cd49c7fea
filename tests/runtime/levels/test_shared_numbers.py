"""Passes over numbers that share unknowns, against NumPy."""

from __future__ import annotations

import numpy as np
import pytest

from arael.runtime.levels.compiled import (
    ComponentSizes,
    PythonRows,
    any_short,
    differs,
    extent,
    gather,
    largest,
    mostly_apart,
    named,
    near,
    put,
    scattered,
    spread,
)

RANDOM = np.random.default_rng(5)


def ints(*numbers: int) -> np.ndarray:
    return np.array(numbers, dtype=np.int64)


def test_numbers_differ_by_a_bit():
    one, other = np.array([0.0, 1.0, 2.0]), np.array([-0.0, 1.0, 2.5])
    assert differs(one, other, ints(0))  # the sign of zero is a bit
    assert not differs(one, other, ints(1))
    assert differs(one, other, ints(1, 2))
    assert not differs(one, other, ints())


def test_unknowns_without_a_source_stay():
    x = np.array([7.0, 7.0, 7.0])
    gather(np.array([1.0, 2.0]), ints(1, -1, 0), x)
    np.testing.assert_array_equal(x, [2.0, 7.0, 1.0])


def test_only_numbers_that_changed_are_scattered():
    x, root = np.array([1.0, 5.0]), ints(0, 1, 1, -1, 0)
    values = np.array([1.0, 5.0, 4.0, 9.0, 2.0])
    at, old, new = scattered(x, root, values, ints(0, 1, 2, 4))
    np.testing.assert_array_equal(at, [2, 4])
    np.testing.assert_array_equal(old, [4.0, 2.0])
    np.testing.assert_array_equal(new, [5.0, 1.0])
    put(values, at, new)
    np.testing.assert_array_equal(values, [1.0, 5.0, 5.0, 9.0, 1.0])
    assert not len(scattered(x, root, values, ints(0, 1, 2, 4))[0])


def test_unknowns_that_are_not_finite_are_refused():
    with pytest.raises(ValueError, match="finite"):
        scattered(np.array([np.nan]), ints(0), np.array([1.0]), ints(0))


def test_runs_are_named_once():
    names = ["A", "", "B", "", "C"]
    assert named(ints(0, 1, 4), ints(0, 0, 2, 2, 4), names) == ("A", "C")
    assert named(ints(), ints(0), names) == ()


def test_largest_magnitude():
    assert largest(np.array([1.0, -3.0, 2.0])) == 3.0
    assert largest(np.zeros(0)) == 0.0


def test_differences_that_are_mostly_large_have_a_large_median():
    assert mostly_apart(np.array([0.0, 2.0, 4.0, 4.5]), 2.0)
    assert not mostly_apart(np.array([0.0, 2.0, 2.5]), 2.0)  # the median is between the two
    assert not mostly_apart(np.zeros(1), 2.0)
    for count in range(2, 40):
        values = RANDOM.normal(size=count)
        for least in (0.1, 0.5, 1.0, 2.0):
            if mostly_apart(values, least):
                assert np.median(np.abs(np.diff(values))) >= least


def test_points_within_a_distance_are_found_in_their_order():
    values, at = RANDOM.uniform(-1.0, 1.0, 60), np.arange(58, -1, -2)
    expected = np.flatnonzero(np.hypot(values[at] - 0.2, values[at + 1] + 0.1) <= 0.5)
    assert near(values, at, 0.2, -0.1, 0.5) == expected.tolist()
    assert near(np.array([3.0, 4.0]), ints(0), 0.0, 0.0, 5.0) == [0]
    assert near(values, ints(), 0.0, 0.0, 5.0) == []


def test_kinds_of_numbers_become_those_of_unknowns():
    found = np.zeros(4, np.int8)
    spread(np.array([1, 0, 2, 3], np.int8), ints(2, -1, 0, 0), found)
    np.testing.assert_array_equal(found, [3, 0, 1, 0])


def test_extent_is_that_of_the_box_or_a_diameter():
    values = np.array([0.0, 0.0, 3.0, -1.0, 5.0])
    assert extent(values, ints(0, 2), ints()) == 3.0
    assert extent(values, ints(0, 2), ints(4)) == 10.0
    assert extent(values, ints(), ints()) == 0.0


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_short_lines_and_lengths_are_found(scale: float):
    values = scale * np.array([0.0, 0.0, 3e-9, 4e-9, 0.0, 0.0, 1.0, 1.0, 1e-9])
    assert not any_short(values, ints(0, 4), ints(8), 0.9e-9 * scale)
    assert any_short(values, ints(0, 4), ints(), 5.1e-9 * scale)
    assert not any_short(values, ints(0, 4), ints(), 4.9e-9 * scale)
    assert any_short(values, ints(4), ints(8), 1.1e-9 * scale)
    assert any_short(np.full(4, np.nan), ints(0), ints(), 1.0)


def test_tolerances_are_relative_to_components():
    count, parts = 40, 5
    axes = RANDOM.integers(0, 5, count).astype(np.int8)
    of_unknown = RANDOM.integers(0, parts, count).astype(np.int32)
    of_row = RANDOM.integers(0, parts, 20).astype(np.int32)
    x = RANDOM.standard_normal(count)
    found = ComponentSizes(axes, of_unknown, of_row).tolerances(x, 1e-3, 1e-6, lambda: 1.0)
    sizes, far = np.zeros(parts), np.zeros(parts)
    for part in range(parts):
        for axis in (1, 2, 3):
            own = x[(of_unknown == part) & (axes == axis)]
            if len(own):
                size = np.abs(own).max() if axis == 3 else np.ptp(own)
                sizes[part] = max(sizes[part], size)
                far[part] = max(far[part], np.abs(own).max())
    sizes[sizes <= 1e-9 * sizes.max()] = sizes.max()
    np.testing.assert_array_equal(found, np.maximum(1e-3 * sizes, 1e-6 * far)[of_row])


def test_components_without_extent_are_as_large_as_the_sketch():
    sizes = ComponentSizes(np.array([1, 2], np.int8), np.zeros(2, np.int32), np.zeros(1, np.int32))
    found = sizes.tolerances(np.array([3.0, 4.0]), 1e-3, 1e-6, lambda: 50.0)
    np.testing.assert_array_equal(found, [0.05])


def test_the_worst_row_is_that_of_the_largest_share():
    rows = PythonRows(lambda x: np.array([x[0] - 1.0, x[1]]), n=2, m=2)
    assert rows.worst([1.5, 0.25], [1.0, 0.25]) == (1, 0.25, 1.0)
    assert rows.worst([1.5, 0.25], [0.1, 0.25]) == (0, 0.5, 5.0)
    row, residual, share = rows.worst([1e9, np.nan], [1.0, 1.0])
    assert (row, share) == (1, np.inf)
    assert np.isnan(residual)
    assert PythonRows(lambda x: np.zeros(0), n=2, m=0).worst([1.0, 2.0], []) == (-1, 0.0, 0.0)


def test_rows_hold_within_their_tolerances():
    rows = PythonRows(lambda x: np.array([x[0] - 1.0, x[1]]), n=2, m=2)
    at = np.array([1.5, 0.0])
    assert rows.holds(at, [0.5, 1e-9])
    assert not rows.holds(at, [0.4, 1e-9])
    assert not rows.holds([np.nan, 0.0], [0.4, 1e-9])
