# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
"""Connected components of a graph, by union-find."""

import numpy as np

from libc.stdint cimport int32_t, int64_t, uint8_t

from arael.runtime.address cimport address, writable


cdef inline int32_t root_of(int32_t* parent, int32_t node) noexcept nogil:
    """Root of a node's tree; on the way every other node is moved up (path halving)."""
    while parent[node] != node:
        parent[node] = parent[parent[node]]
        node = parent[node]
    return node


cdef inline void join(int32_t* parent, int32_t one, int32_t other) noexcept nogil:
    one, other = root_of(parent, one), root_of(parent, other)
    # The first node of a component is its root, which numbers components in order of their nodes.
    if one < other:
        parent[other] = one
    else:
        parent[one] = other


def connected(column_start, rows, ones, others, idle):
    """Components of a graph whose edges are blocks of a pattern, and pairs beside them.

    Parameters
    ----------
    column_start : (n + 1,) int64, first entry of each node in `rows`
    rows : (m,) int64, neighbours
    ones, others : (k,) int64, nodes that are joined as well
    idle : (n,) uint8, nodes that join nothing and form no component

    Returns
    -------
    count : int
    labels : (n,) int32, component of each node, numbered in order of their first nodes; 0 for idle
        nodes
    """
    cdef Py_ssize_t n = len(column_start) - 1, k, p, pairs = len(ones)
    cdef const int64_t* start = <const int64_t*>address(column_start, np.int64)
    cdef const int64_t* row = <const int64_t*>address(rows, np.int64)
    cdef const int64_t* one = <const int64_t*>address(ones, np.int64)
    cdef const int64_t* other = <const int64_t*>address(others, np.int64, pairs)
    cdef const uint8_t* out = <const uint8_t*>address(idle, np.uint8, n)
    labels = np.arange(n, dtype=np.int32)
    cdef int32_t* parent = <int32_t*>writable(labels, np.int32, n)
    cdef int32_t count = 0
    with nogil:
        for k in range(n):
            for p in range(start[k], start[k + 1]):
                if not (out[k] or out[row[p]]):
                    join(parent, <int32_t>k, <int32_t>row[p])
        for p in range(pairs):
            if not (out[one[p]] or out[other[p]]):
                join(parent, <int32_t>one[p], <int32_t>other[p])
        # Parents have smaller numbers than their children, so that they have their label by now.
        for k in range(n):
            if out[k]:
                parent[k] = -1
            elif parent[k] == k:
                parent[k] = -1 - count
                count += 1
            else:
                parent[k] = parent[parent[k]]
        for k in range(n):
            parent[k] = -1 - parent[k]
    return count, labels
