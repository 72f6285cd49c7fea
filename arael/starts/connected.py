"""Connected components of a graph."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arael.runtime.assembly.compiled import connected

Ints = NDArray[np.int64]


def components(count: int, a: Ints, b: Ints) -> Ints:
    """Component of each node, named by its smallest node.

    Parameters
    ----------
    count : number of nodes
    a, b : (m,) nodes that each edge joins

    Returns
    -------
    (count,) int64
    """
    alone, nothing = np.zeros(count + 1, np.int64), np.zeros(0, np.int64)
    ends = np.ascontiguousarray(a, np.int64), np.ascontiguousarray(b, np.int64)
    found, labels = connected(alone, nothing, ends[0], ends[1], np.zeros(count, np.uint8))
    if found == 1:  # as most graphs are
        return np.zeros(count, np.int64)
    # Labels are numbered in order of their first nodes.
    top = np.maximum.accumulate(labels)
    new = np.ones(count, np.bool_)
    np.greater(top[1:], top[:-1], out=new[1:])
    first = np.flatnonzero(new)
    return np.asarray(first[labels], np.int64)
