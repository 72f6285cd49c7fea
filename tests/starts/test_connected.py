"""Connected components against SciPy's."""

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from arael.runtime.assembly.components import graph_components


@pytest.mark.parametrize("seed", range(20))
def test_components_are_those_of_scipy_named_by_their_first_node(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n, m = int(rng.integers(1, 60)), int(rng.integers(0, 60))
    a, b = rng.integers(0, n, (2, m))
    found = graph_components(n, a, b)
    _, labels = connected_components(coo_array((np.ones(m), (a, b)), (n, n)), directed=False)
    first = [int(np.argmax(labels == label)) for label in labels]
    assert found.tolist() == first


def test_a_long_chain_against_its_order() -> None:
    order = np.random.default_rng(0).permutation(5000)
    assert not graph_components(5000, order[:-1], order[1:]).any()


def test_without_edges_each_node_is_a_component() -> None:
    empty = np.empty(0, np.int64)
    assert graph_components(3, empty, empty).tolist() == [0, 1, 2]
