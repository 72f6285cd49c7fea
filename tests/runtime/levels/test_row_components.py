"""Components of rows, against those of SciPy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import bmat, csr_array
from scipy.sparse.csgraph import connected_components

from arael.runtime.levels.compiled import PythonRows, components


@pytest.mark.parametrize("seed", range(8))
def test_components_are_those_of_the_graph_of_rows_and_unknowns(seed: int) -> None:
    random = np.random.default_rng(seed)
    m, n = int(random.integers(1, 30)), int(random.integers(1, 30))
    pattern = random.random((m, n)) < 1.2 / n
    found = components(PythonRows(lambda x: np.zeros(m), n=n, m=m, pattern=pattern))
    graph = csr_array(pattern.astype(float))
    _, expected = connected_components(bmat([[None, graph], [graph.T, None]]), directed=False)
    assert found.shape == (m + n,)
    pairs = set(zip(found.tolist(), expected.tolist(), strict=True))
    assert len(pairs) == len(set(found.tolist())) == len(set(expected.tolist()))
    # numbered in the order in which they appear
    _, first = np.unique(found, return_index=True)
    assert (np.diff(first) > 0).all()


def test_without_rows_every_unknown_is_a_component() -> None:
    rows = PythonRows(lambda x: np.zeros(0), n=3, m=0)
    assert components(rows).tolist() == [0, 1, 2]
