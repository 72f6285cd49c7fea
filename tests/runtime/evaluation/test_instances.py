"""Data of instances by instance and in lane order."""

import numpy as np
import pytest

from arael.runtime.evaluation.instances import Instances


@pytest.mark.parametrize("n", [0, 1, 8, 21])
@pytest.mark.parametrize("columns", [0, 3])
@pytest.mark.parametrize("ordered", [False, True])
def test_data_from_lanes(n: int, columns: int, ordered: bool) -> None:
    rng = np.random.default_rng(n)
    data = rng.normal(size=(n, columns))
    order = rng.permutation(n) if ordered else None
    instances = Instances(np.arange(n), data.copy(), np.zeros(0))
    for lanes in (4, 8, 4):
        found = instances.in_lanes(lanes, order)
        expected = data if order is None else data[order]
        assert found.shape == (-(-n // lanes), columns, lanes)
        for k in range(len(found) * lanes):
            at = min(k, n - 1)
            np.testing.assert_array_equal(found[k // lanes, :, k % lanes], expected[at])
        np.testing.assert_array_equal(instances.data, data)
    assert instances.in_lanes(4, order) is instances.in_lanes(4, order)


def test_another_order_is_laid_out_anew() -> None:
    data = np.arange(12.0).reshape(12, 1)
    instances = Instances(np.arange(12), data.copy(), np.zeros(0))
    first = instances.in_lanes(4, None).copy()
    back = np.arange(12)[::-1]
    np.testing.assert_array_equal(instances.in_lanes(4, back).ravel(), data[::-1, 0])
    np.testing.assert_array_equal(instances.in_lanes(4, None), first)
