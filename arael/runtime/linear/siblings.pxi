"""Merges children of one front that have nearly the same rows.

Landmarks seen from the same poses are uncoupled leaves of the elimination tree, so merging children
with parents never merges them; yet each of them would have a separate update matrix from three
columns, which is written, read and added entry by entry. After merging, their update matrices are
summed in registers. The cost is explicit zeros: between the columns, which are not coupled, and
where one of them lacks a row that another has.
"""

import numpy as np

from libc.stdlib cimport qsort

from arael.runtime.address cimport address, writable

# Number of candidate groups of a child: the latest ones of its parent. Children are sorted by rows.
cdef enum:
    OPEN = 24


cdef struct Child:
    int64_t parent, low, high       # first and last of its rows
    int64_t node


cdef int by_rows(const void* a, const void* b) noexcept nogil:
    """Order of children: by parent, then by their first and last rows."""
    cdef const Child* x = <const Child*>a
    cdef const Child* y = <const Child*>b
    if x.parent != y.parent:
        return -1 if x.parent < y.parent else 1
    if x.low != y.low:
        return -1 if x.low < y.low else 1
    if x.high != y.high:
        return -1 if x.high < y.high else 1
    return (x.node > y.node) - (x.node < y.node)


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
    cdef Py_ssize_t n = len(weights), ns = len(parent)
    order = np.arange(n)
    begin, up, of = ints(start), ints(parent), ints(weights)
    found = joined_siblings(n, ns, begin, up, row_start, rows, ints(order), of)
    return np.arange(ns) if found is None else found


cdef joined_siblings(
    Py_ssize_t n,
    Py_ssize_t ns,
    const int64_t* begin,
    const int64_t* parent,
    row_start,
    rows,
    const int64_t* order,
    const int64_t* weights,
):
    """What `join_siblings` returns, or None if no supernode joins another.

    Parameters
    ----------
    begin, parent : of the supernodes
    order : (n,) blocks by position; weights : (n,) scalars of each block
    """
    cdef const int64_t* rs = ints(row_start)
    cdef const int64_t* r = ints(rows)
    cdef Py_ssize_t s, c, g, i, j, p, count, first, open_now, best, widest = 0, children = 0
    cdef Py_ssize_t end, last_child
    cdef bint joined = False
    counted = np.zeros(ns + 1, dtype=np.int64)
    cdef int64_t* family = filled(counted)
    for s in range(ns):
        if parent[s] >= 0:
            family[parent[s]] += 1
            children += 1
    for s in range(ns):
        if family[s] > 1:
            widest = max(widest, begin[s + 1] - begin[s] + rs[s + 1] - rs[s])
    if widest == 0:
        return None
    sequence = np.empty(4 * children, dtype=np.int64)
    cdef Child* child = <Child*>filled(sequence)
    i = 0
    for s in range(ns):
        if parent[s] >= 0:
            child[i].parent, child[i].node = parent[s], s
            child[i].low, child[i].high = r[rs[s]], r[rs[s + 1] - 1]
            i += 1
    qsort(child, children, sizeof(Child), by_rows)
    into, marks = np.arange(ns, dtype=np.int64), np.empty(2 * n, dtype=np.int64)
    groups = np.empty(OPEN * widest, dtype=np.int64)
    cdef int64_t* last = filled(into)
    cdef int64_t* seen = filled(marks)
    cdef int64_t* w = seen + n
    cdef int64_t* held = filled(groups)     # rows of each group, `widest` apart
    cdef int64_t[OPEN] size, lead
    cdef double[OPEN] k, below, spent
    cdef double mine, mine_rows, alone, union_rows, gain, most
    for p in range(n):
        seen[p] = -1
        w[p] = weights[order[p]]
    end = children
    while end > 0:  # families from the last to the first
        s = child[end - 1].parent
        last_child = end
        end -= family[s]
        if family[s] < 2:
            continue
        open_now = count = 0
        for i in range(end, last_child):
            c = child[i].node
            mine = mine_rows = 0
            for p in range(begin[c], begin[c + 1]):
                mine += w[p]
            for p in range(rs[c], rs[c + 1]):
                seen[r[p]] = c
                mine_rows += w[r[p]]
            alone = front_time(mine, mine_rows)
            most, best = 0, -1
            for g in range(open_now):
                union_rows = mine_rows
                for j in range(size[g]):
                    if seen[held[g * widest + j]] != c:
                        union_rows += w[held[g * widest + j]]
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
                joined = True
                first = lead[best]
                if c > first:
                    last[first] = lead[best] = c
                else:
                    last[c] = first
            # Rows of the group are marked, so that only new ones of the child are added.
            for j in range(size[best]):
                seen[held[best * widest + j]] = -1
            for p in range(rs[c], rs[c + 1]):
                if seen[r[p]] == c:
                    held[best * widest + size[best]] = r[p]
                    size[best] += 1
                    below[best] += w[r[p]]
            k[best] += mine
            spent[best] = front_time(k[best], below[best])
    if not joined:
        return None
    for s in range(ns - 1, -1, -1):
        last[s] = last[last[s]]
    return into
