"""Connected components of a graph."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int64]


def components(count: int, a: Ints, b: Ints) -> Ints:
    """Component of each node, named by its smallest node.

    The roots of the two ends of each edge are joined and paths halved until no edge connects two
    components: O(log count) rounds over all edges. (`scipy.sparse.csgraph` does the same, but
    importing it takes longer than a whole solve of most pose graphs.)

    Parameters
    ----------
    count : number of nodes
    a, b : (m,) nodes that each edge joins

    Returns
    -------
    (count,) int64
    """
    root = np.arange(count, dtype=np.int64)
    while True:
        ends = root[a], root[b]
        low, high = np.minimum(*ends), np.maximum(*ends)
        if np.array_equal(low, high):
            return root
        np.minimum.at(root, high, low)
        while not np.array_equal(root, root[root]):
            root = root[root]
