"""Nested dissection: split the graph by separators; order the parts first, separators last."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arael.runtime.linear.planning import find_separator, minimum_degree

Ints = NDArray[np.int64]

# Parts with fewer vertices are ordered by minimum degree.
_LEAF = 120


def nested_dissection(start: Ints, neighbours: Ints, weights: Ints) -> Ints:
    """Order the vertices of an undirected graph for little fill and a bushy elimination tree.

    After A. George, "Nested dissection of a regular finite element mesh", SIAM J. Numer. Anal. 10
    (1973). Small parts are ordered by minimum degree, with the surrounding separators as vertices
    that are not eliminated.

    Parameters
    ----------
    start, neighbours, weights
        Graph as in `minimum_degree`.

    Returns
    -------
    (n,) int64
        The vertices in the order of elimination.
    """
    n = len(weights)
    order = np.empty(n, dtype=np.int64)
    local = np.full(n, -1, dtype=np.int64)
    # Vertices coupled with nearly all others, such as parameters of the root, would be in every
    # separator and reduce all distances: they are ordered last, and the others are split without
    # them.
    sparse, dense = apart(start)
    order[len(sparse) :] = dense
    # Vertices still to be split, and the end of their range in the order.
    waiting = [(sparse, len(sparse))]
    while waiting:
        vertices, end = waiting.pop()
        begin = end - len(vertices)
        if len(vertices) > _LEAF:
            local[vertices] = np.arange(len(vertices))
            part_start, part = _induced(start, neighbours, vertices, local)
            local[vertices] = -1
            side = find_separator(part_start, part, weights[vertices])
            left, right, between = (vertices[side == k] for k in range(3))
            if len(left) and len(right) and len(between) < len(vertices) // 3:
                order[end - len(between) : end] = between
                waiting.append((right, end - len(between)))
                waiting.append((left, begin + len(left)))
                continue
        order[begin:end] = _leaf(start, neighbours, weights, vertices, local)
    return order


def apart(start: Ints) -> tuple[Ints, Ints]:
    """Vertices of a graph with few neighbours, and those with very many, both ascending.

    Many means more than ten times the square root of the number of vertices, as in
    `minimum_degree`.
    """
    degree = np.diff(start)
    dense = degree > max(16.0, 10.0 * len(degree) ** 0.5)
    return np.flatnonzero(~dense), np.flatnonzero(dense)


def _leaf(start: Ints, neighbours: Ints, weights: Ints, vertices: Ints, local: Ints) -> Ints:
    """Order a part by minimum degree without eliminating the vertices around it."""
    around = neighbours[_entries(start, vertices)]
    local[vertices] = 0
    around = np.unique(around[local[around] < 0])
    both = np.concatenate((vertices, around))
    local[both] = np.arange(len(both))
    part_start, part = _induced(start, neighbours, both, local)
    local[both] = -1
    order = minimum_degree(part_start, part, weights[both], staying=len(around))
    return vertices[order]


def _entries(start: Ints, vertices: Ints) -> Ints:
    """Places of the neighbours of some vertices, vertex by vertex."""
    length = start[vertices + 1] - start[vertices]
    first = np.repeat(start[vertices] - (np.cumsum(length) - length), length)
    return np.asarray(first + np.arange(int(length.sum())), dtype=np.int64)


def _induced(start: Ints, neighbours: Ints, vertices: Ints, local: Ints) -> tuple[Ints, Ints]:
    """Subgraph of some vertices; `local` holds their new numbers and -1 for all others."""
    length = start[vertices + 1] - start[vertices]
    to = local[neighbours[_entries(start, vertices)]]
    inside = to >= 0
    owner = np.repeat(np.arange(len(vertices)), length)[inside]
    part_start = np.searchsorted(owner, np.arange(len(vertices) + 1)).astype(np.int64)
    return part_start, to[inside]
