"""Loops over the blocks of a pattern: its graph, and the places of its blocks in fronts.

Each is a pass or two over the blocks, which takes less time than a NumPy call for each step of it.
"""

import numpy as np

from libc.stdint cimport int64_t

from arael.runtime.address cimport address, writable
from arael.runtime.linear.lead cimport led


cdef enum:
    HALF = 24       # bits of a height or a width in a table of blocks


def adjacency(pattern):
    """Undirected graph of the off-diagonal blocks.

    Parameters
    ----------
    pattern : BlockPattern

    Returns
    -------
    start : (nb + 1,) int64
    neighbours : (start[nb],) int64
        Neighbours of block v, ascending: ``neighbours[start[v]:start[v + 1]]``.
    """
    cdef Py_ssize_t nb = len(pattern.sizes), column, k
    cdef const int64_t* begin = ints(pattern.column_start)
    cdef const int64_t* row = ints(pattern.rows)
    starts = np.zeros(nb + 2, dtype=np.int64)
    neighbours = np.empty(2 * (len(pattern.rows) - nb), dtype=np.int64)
    cdef int64_t* start = <int64_t*>writable(starts, np.int64)
    cdef int64_t* to = <int64_t*>writable(neighbours, np.int64)
    with nogil:
        # Counted one place further on, so that filling moves each start to where it belongs.
        for column in range(nb):
            for k in range(begin[column] + 1, begin[column + 1]):
                start[column + 2] += 1
                start[row[k] + 2] += 1
        for column in range(1, nb + 1):
            start[column + 1] += start[column]
        for column in range(nb):  # smaller neighbours of a block come from columns before its own
            for k in range(begin[column] + 1, begin[column + 1]):
                to[start[column + 1]] = row[k]
                start[column + 1] += 1
                to[start[row[k] + 1]] = column
                start[row[k] + 1] += 1
    return starts[:nb + 1], neighbours


def reach_of(pattern):
    """Largest distance of an entry below the diagonal, in scalars."""
    cdef Py_ssize_t nb = len(pattern.sizes), column, k
    cdef const int64_t* begin = ints(pattern.column_start)
    cdef const int64_t* row = ints(pattern.rows)
    cdef const int64_t* offset = ints(pattern.offsets)
    cdef int64_t most = 0
    for column in range(nb):
        # Rows ascend within a column; the diagonal block, which may be empty, is the first.
        k = begin[column + 1] - 1
        if k >= begin[column]:
            most = max(most, offset[row[k] + 1] - 1 - offset[column])
    return most


def place_blocks(pattern, supernodes, fronts, Py_ssize_t pad):
    """Offsets of the blocks of a matrix in the storage of its multifrontal factor.

    Parameters
    ----------
    pattern : BlockPattern
    supernodes : Supernodes
    fronts : Fronts
    pad : int
        Scalars that rows are padded to a multiple of.

    Returns
    -------
    front_start : (ns + 1,) int64
        Blocks of front s are ``front_start[s]:front_start[s + 1]``.
    blocks : (nblocks, 4) int64
        Table for `put` in blocks.pxi.
    """
    cdef Py_ssize_t nb = len(pattern.sizes), ns = len(supernodes.parent), m = len(pattern.rows)
    cdef Py_ssize_t column, k, i, s, lo, hi, middle, at
    cdef int64_t one, other, low, high, row, apart, how, inside
    cdef const int64_t* size = ints(pattern.sizes)
    cdef const int64_t* begin = ints(pattern.column_start)
    cdef const int64_t* rows = ints(pattern.rows)
    cdef const int64_t* value = ints(pattern.value_start)
    cdef const int64_t* order = ints(supernodes.order)
    cdef const int64_t* first_column = ints(supernodes.start)
    cdef const int64_t* row_start = ints(supernodes.row_start)
    cdef const int64_t* below_rows = ints(supernodes.rows)
    cdef const int64_t* first = ints(fronts.first)
    cdef const int64_t* columns = ints(fronts.columns)
    cdef const int64_t* below = ints(fronts.below)
    cdef const int64_t* triangle = ints(fronts.triangle)
    cdef const int64_t* panel = ints(fronts.panel)
    work = np.zeros((4, nb + 2), dtype=np.int64)
    cdef int64_t* position = <int64_t*>writable(work, np.int64)
    cdef int64_t* offset = position + nb + 2
    cdef int64_t* owner = offset + nb + 2
    cdef int64_t* next_place = owner + nb + 2
    widths = np.zeros(len(supernodes.rows) + 1, dtype=np.int64)
    cdef int64_t* before = <int64_t*>writable(widths, np.int64)
    starts = np.zeros(ns + 1, dtype=np.int64)
    cdef int64_t* front_start = <int64_t*>writable(starts, np.int64)
    blocks = np.empty((m, 4), dtype=np.int64)
    cdef int64_t* table = <int64_t*>writable(blocks, np.int64)
    cdef int64_t* to
    with nogil:
        for i in range(nb):
            position[order[i]] = i
            offset[i + 1] = offset[i] + size[order[i]]
        for s in range(ns):
            for i in range(first_column[s], first_column[s + 1]):
                owner[i] = s
        for k in range(row_start[ns]):
            before[k + 1] = before[k] + size[order[below_rows[k]]]
        # Blocks are sorted by the first of their two positions, which ascends with the fronts.
        for column in range(nb):
            for k in range(begin[column], begin[column + 1]):
                low = min(position[column], position[rows[k]])
                next_place[low + 1] += 1
                front_start[owner[low] + 1] += 1
        for i in range(nb):
            next_place[i + 1] += next_place[i]
        for s in range(ns):
            front_start[s + 1] += front_start[s]
        for column in range(nb):
            one = position[column]
            for k in range(begin[column], begin[column + 1]):
                other = position[rows[k]]
                low, high = min(one, other), max(one, other)
                s = owner[low]
                inside = high < first_column[s + 1]
                if inside:
                    row = offset[high] - first[s]
                    apart = led(columns[s], pad)
                    at = triangle[s]
                else:
                    lo, hi = row_start[s], row_start[s + 1]
                    while lo < hi:
                        middle = (lo + hi) // 2
                        if below_rows[middle] < high:
                            lo = middle + 1
                        else:
                            hi = middle
                    row = before[lo] - before[row_start[s]]
                    apart = led(below[s] + 1, pad)
                    at = panel[s]
                how = 2 if one == other else 1 if other < one else 0
                to = table + 4 * next_place[low]
                next_place[low] += 1
                to[0] = value[k]
                to[1] = at + row + (offset[low] - first[s]) * apart
                to[2] = apart
                to[3] = how << (2 * HALF) | size[rows[k]] << HALF | size[column]
    return starts, blocks
