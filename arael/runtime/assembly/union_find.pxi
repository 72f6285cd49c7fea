"""Connected components of a graph, by union-find, and what belongs to each of them."""

import numpy as np

from libc.stdint cimport int32_t, int64_t, uint8_t

from arael.runtime.address cimport address, writable


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
    cdef int32_t count
    with nogil:
        for k in range(n):
            for p in range(start[k], start[k + 1]):
                if not (out[k] or out[row[p]]):
                    join(parent, <int32_t>k, <int32_t>row[p])
        for p in range(pairs):
            if not (out[one[p]] or out[other[p]]):
                join(parent, <int32_t>one[p], <int32_t>other[p])
        for k in range(n):
            if out[k]:
                parent[k] = -1
        count = numbered(parent, n)
    return count, labels


def labels_of_instances(gradient_at, component, int32_t none):
    """(n,) int32, component of the first scalar that each instance uses and that is of one.

    Parameters
    ----------
    gradient_at : (n, uses) int32, first scalar of each use; beyond the last: not solved for
    component : (scalars,) int32, component of each scalar of the system; -1 in idle blocks
    none : component of instances without such a scalar
    """
    cdef Py_ssize_t n = gradient_at.shape[0], uses = gradient_at.shape[1], size = len(component)
    cdef Py_ssize_t k, u
    cdef const int32_t* at = <const int32_t*>address(gradient_at, np.int32)
    cdef const int32_t* label = <const int32_t*>address(component, np.int32)
    found = np.empty(n, dtype=np.int32)
    cdef int32_t* to = <int32_t*>writable(found, np.int32)
    with nogil:
        for k in range(n):
            to[k] = none
            for u in range(uses):
                if 0 <= at[u] < size and label[at[u]] >= 0:
                    to[k] = label[at[u]]
                    break
            at += uses
    return found


def runs_of_values(column_start, value_start, labels, int64_t value_count):
    """(m, 3) int64: begin, end and component of runs of values of a pattern.

    Parameters
    ----------
    column_start, value_start : as `BlockPattern` has them
    labels : (blocks,) int32, component of each block column
    value_count : scalars of all blocks
    """
    cdef Py_ssize_t nb = len(column_start) - 1, m = len(value_start), column, k, count = 0
    cdef const int64_t* start = <const int64_t*>address(column_start, np.int64)
    cdef const int64_t* begin = <const int64_t*>address(value_start, np.int64)
    cdef const int32_t* label = <const int32_t*>address(labels, np.int32, nb)
    orders = np.argsort(value_start, kind="stable")
    cdef const int64_t* order = <const int64_t*>address(orders, np.int64, m)
    owners, runs = np.empty(m, dtype=np.int32), np.empty((m, 3), dtype=np.int64)
    cdef int32_t* owner = <int32_t*>writable(owners, np.int32)
    cdef int64_t* run = <int64_t*>writable(runs, np.int64)
    with nogil:
        for column in range(nb):
            for k in range(start[column], start[column + 1]):
                owner[k] = label[column]
        for k in range(m):
            if count and run[3 * count - 1] == owner[order[k]]:
                continue
            if count:
                run[3 * count - 2] = begin[order[k]]
            run[3 * count], run[3 * count + 2] = begin[order[k]], owner[order[k]]
            count += 1
        if count:
            run[3 * count - 2] = value_count
    return runs[:count].copy()
