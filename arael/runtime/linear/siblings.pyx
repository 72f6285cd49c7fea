# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
"""Merges children of one front that have nearly the same rows.

Landmarks seen from the same poses are uncoupled leaves of the elimination tree, so merging children
with parents never merges them; yet each of them would have a separate update matrix from three
columns, which is written, read and added entry by entry. After merging, their update matrices are
summed in registers. The cost is explicit zeros: between the columns, which are not coupled, and
where one of them lacks a row that another has.
"""

import numpy as np

from arael.runtime.linear.front_time cimport front_time

# Number of candidate groups of a child: the latest ones of its parent. Children are sorted by rows.
cdef enum:
    OPEN = 24


def join_siblings(start, parent, row_start, rows, weights):
    """Merge children of the same front where that makes the factorisation faster.

    Parameters
    ----------
    start, parent, row_start, rows
        As in `Supernodes`.
    weights : (n,) int64
        Scalars of the block at each position.

    Returns
    -------
    (ns,) int64
        For each supernode the one that it joins, the last of its group.
    """
    cdef Py_ssize_t ns = len(parent), n = len(weights), s, c, g, i, j, p, count, first, open_now
    cdef Py_ssize_t best, widest = 0
    cdef long long[::1] rs = row_start, r = rows
    cdef long long[::1] w = np.ascontiguousarray(weights, dtype=np.int64)
    before = np.concatenate(([0], np.cumsum(weights))).astype(np.int64)
    cdef long long[::1] at = before
    cdef long long[::1] begin = start
    into = np.arange(ns, dtype=np.int64)
    cdef long long[::1] last = into
    # Children of one parent are grouped, sorted by first and last rows.
    has = np.flatnonzero(parent >= 0)
    low, high = rows[row_start[has]], rows[row_start[has + 1] - 1]
    sequence = has[np.lexsort((high, low, parent[has]))].astype(np.int64)
    cdef long long[::1] child = sequence
    cdef long long[::1] family = np.searchsorted(parent[sequence], np.arange(ns + 1))
    for s in range(ns):
        if family[s + 1] - family[s] > 1:
            widest = max(widest, begin[s + 1] - begin[s] + rs[s + 1] - rs[s])
    if widest == 0:
        return into
    cdef long long[:, ::1] held = np.empty((OPEN, widest), dtype=np.int64)
    cdef long long[::1] size = np.zeros(OPEN, dtype=np.int64)
    cdef long long[::1] lead = np.zeros(OPEN, dtype=np.int64)
    cdef double[::1] k = np.zeros(OPEN), below = np.zeros(OPEN), spent = np.zeros(OPEN)
    cdef long long[::1] seen = np.full(n, -1, dtype=np.int64)
    cdef double mine, mine_rows, alone, union_rows, gain, most
    for s in range(ns - 1, -1, -1):
        if family[s + 1] - family[s] < 2:
            continue
        open_now = count = 0
        for i in range(family[s], family[s + 1]):
            c = child[i]
            mine, mine_rows = at[begin[c + 1]] - at[begin[c]], 0
            for p in range(rs[c], rs[c + 1]):
                seen[r[p]] = c
                mine_rows += w[r[p]]
            alone = front_time(mine, mine_rows)
            most, best = 0, -1
            for g in range(open_now):
                union_rows = mine_rows
                for j in range(size[g]):
                    if seen[held[g, j]] != c:
                        union_rows += w[held[g, j]]
                gain = alone + spent[g] - front_time(k[g] + mine, union_rows)
                if gain > most:
                    most, best = gain, g
            if best < 0:
                best = count % OPEN
                count += 1
                open_now = min(count, OPEN)
                size[best], k[best], below[best] = 0, 0, 0
                lead[best] = c
            else:
                first = lead[best]
                if c > first:
                    last[first] = lead[best] = c
                else:
                    last[c] = first
            # Rows of the group are marked, so that only new ones of the child are added.
            for j in range(size[best]):
                seen[held[best, j]] = -1
            for p in range(rs[c], rs[c + 1]):
                if seen[r[p]] == c:
                    held[best, size[best]] = r[p]
                    size[best] += 1
                    below[best] += w[r[p]]
            k[best] += mine
            spent[best] = front_time(k[best], below[best])
    for s in range(ns - 1, -1, -1):
        last[s] = last[last[s]]
    return into
