# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
"""Supernodes of a block factor: runs of columns with equal rows, merged where that is faster."""

import numpy as np

from libc.stdlib cimport qsort

from arael.runtime.linear.front_time cimport front_time

from arael.runtime.linear.siblings import join_siblings
from arael.runtime.linear.trees import column_counts, elimination_tree, postorder


cdef enum:
    CACHE = 128 * 1024      # scalars of the second-level cache


cdef class Supernodes:
    """Symbolic factor: the columns of each supernode and the rows below them.

    Attributes
    ----------
    order : (n,) int64
        Blocks in the order of elimination.
    start : (ns + 1,) int64
        Supernode s has the columns at positions ``start[s]:start[s + 1]`` of the order.
    parent : (ns,) int64
        Its parent in the tree of supernodes, -1 for a root; children come before parents.
    row_start : (ns + 1,) int64
    rows : (row_start[ns],) int64
        Positions below the columns of supernode s, ascending, in
        ``rows[row_start[s]:row_start[s + 1]]``.
    """

    cdef readonly object order, start, parent, row_start, rows

    def __init__(self, order, start, parent, row_start, rows):
        self.order, self.start, self.parent = order, start, parent
        self.row_start, self.rows = row_start, rows


def find_supernodes(start, neighbours, weights, order):
    """Symbolic factorisation of a graph in a given order.

    The order is refined by postorders, which change neither fill nor work.

    Parameters
    ----------
    start, neighbours : int arrays
        Undirected graph as in `minimum_degree`.
    weights : (n,) int64
        Scalars of each vertex.
    order : (n,) int64

    Returns
    -------
    Supernodes
    """
    parents = elimination_tree(start, neighbours, order)
    order, parents = _relabel(order, parents, postorder(parents))
    weight = np.ascontiguousarray(weights[order], dtype=np.int64)
    counts, rows = column_counts(start, neighbours, order, parents, weight)
    first = _maximal(parents, counts)
    owner, tree = _amalgamate(first, parents, weight, rows)
    order, begin, tree = _gather(order, owner, tree)
    row_start, rows = _structure(start, neighbours, order, begin, tree)
    into = join_siblings(begin, tree, row_start, rows, weights[order])
    keep = np.flatnonzero(into == np.arange(len(into)))
    if len(keep) < len(into):
        number = np.searchsorted(keep, into)
        owner = np.repeat(number, np.diff(begin))
        tree = np.where(tree[keep] < 0, -1, number[tree[keep]])
        order, begin, tree = _gather(order, owner, tree)
        row_start, rows = _structure(start, neighbours, order, begin, tree)
    return Supernodes(order, begin, tree, row_start, rows)


def price_of(Supernodes nodes, sizes):
    """Cost of a symbolic factor.

    Parameters
    ----------
    nodes : Supernodes
    sizes : (n,) int64
        Scalars of each block, in the original order.

    Returns
    -------
    nnz : int
        Scalars of the factor's lower triangle, explicit zeros included.
    flops : float
    nanoseconds : float
        By the model of fronts.
    scattered : float
        Columns of blocks that are added to fronts beyond the second-level cache.
    """
    cdef Py_ssize_t ns = len(nodes.parent), s, p
    cdef const long long[::1] start = nodes.start, parent = nodes.parent, order = nodes.order
    cdef const long long[::1] row_start = nodes.row_start, rows = nodes.rows
    cdef const long long[::1] size = sizes
    cdef double[::1] own = np.zeros(ns), below = np.zeros(ns)
    cdef double k, r, flops = 0, time = 0, scattered = 0
    cdef long long nnz = 0
    for s in range(ns):
        for p in range(start[s], start[s + 1]):
            own[s] += size[order[p]]
        for p in range(row_start[s], row_start[s + 1]):
            below[s] += size[order[rows[p]]]
        k, r = own[s], below[s]
        nnz += <long long>(k * (k + 1) / 2 + k * r)
        flops += k * k * k / 3 + k * k * r + k * r * r
        time += front_time(k, r)
    for s in range(ns):
        p = parent[s]
        if p >= 0 and (own[p] + below[p]) * (own[p] + below[p]) > CACHE:
            scattered += below[s] * max(row_start[s + 1] - row_start[s], 1) / 2.0
    return nnz, flops, time, scattered


def _gather(order, owner, tree):
    """Order, starts and parents with the columns of each supernode contiguous.

    Within a supernode columns keep their order.
    """
    node_order = postorder(tree)
    rank = np.empty(len(node_order), dtype=np.int64)
    rank[node_order] = np.arange(len(node_order))
    columns = np.argsort(rank[owner], kind="stable")
    begin = np.searchsorted(rank[owner][columns], np.arange(len(node_order) + 1)).astype(np.int64)
    tree = tree[node_order]
    tree = np.where(tree < 0, -1, rank[tree]).astype(np.int64)
    return np.ascontiguousarray(order[columns]), begin, tree


def _relabel(order, parents, sequence):
    """Order and parents after reordering the positions by `sequence`."""
    inverse = np.empty(len(sequence), dtype=np.int64)
    inverse[sequence] = np.arange(len(sequence))
    moved = parents[sequence]
    return order[sequence], np.where(moved < 0, -1, inverse[moved])


def _maximal(parents, counts):
    """First columns of runs in which each column has the rows of the next plus the next itself."""
    n = len(parents)
    if n == 0:
        return np.zeros(0, dtype=np.int64)
    joined = (parents[: n - 1] == np.arange(1, n)) & (counts[: n - 1] == counts[1:] + 1)
    return np.flatnonzero(np.concatenate(([True], ~joined)))


cdef _amalgamate(first, parents, weight, below):
    """Merge supernodes into their parents where that makes the factorisation faster.

    Returns the merged supernode of each column, and the parent of each merged supernode.
    """
    cdef Py_ssize_t n = len(parents), ns = len(first), s, c, p, best, previous, best_previous
    cdef long long[::1] f = np.append(first, n).astype(np.int64)
    cdef long long[::1] up = np.ascontiguousarray(parents, dtype=np.int64)
    cdef long long[::1] w = np.ascontiguousarray(weight, dtype=np.int64)
    cdef long long[::1] b = np.ascontiguousarray(below, dtype=np.int64)
    node = np.repeat(np.arange(ns), np.diff(np.append(first, n)))
    cdef long long[::1] node_of = np.ascontiguousarray(node, dtype=np.int64)
    cdef double[::1] k = np.zeros(ns), r = np.zeros(ns), t = np.zeros(ns)
    cdef long long[::1] head = np.full(ns, -1, dtype=np.int64)
    cdef long long[::1] sibling = np.full(ns, -1, dtype=np.int64)
    cdef long long[::1] into = np.arange(ns, dtype=np.int64)
    tree = np.full(ns, -1, dtype=np.int64)
    cdef long long[::1] parent = tree
    cdef double gain, most, merged
    for s in range(ns):
        for c in range(f[s], f[s + 1]):
            k[s] += w[c]
        r[s] = b[f[s + 1] - 1]
        t[s] = front_time(k[s], r[s])
        p = up[f[s + 1] - 1]
        if p >= 0:
            parent[s] = node_of[p]
    for s in range(ns):
        # All children of s were visited and are in its list.
        while True:
            most = 0
            best = best_previous = previous = -1
            c = head[s]
            while c >= 0:
                merged = front_time(k[c] + k[s], r[s])
                gain = t[c] + t[s] - merged
                if gain > most:
                    most, best, best_previous = gain, c, previous
                previous = c
                c = sibling[c]
            if best < 0:
                break
            into[best] = s
            k[s] += k[best]
            t[s] = front_time(k[s], r[s])
            # The grandchildren replace the child.
            if best_previous < 0:
                head[s] = sibling[best]
            else:
                sibling[best_previous] = sibling[best]
            c = head[best]
            while c >= 0:
                previous = sibling[c]
                sibling[c] = head[s]
                head[s] = c
                parent[c] = s
                c = previous
        if parent[s] >= 0:
            sibling[s] = head[parent[s]]
            head[parent[s]] = s
    for s in range(ns - 1, -1, -1):
        into[s] = into[into[s]]
    keep = np.flatnonzero(np.asarray(into) == np.arange(ns))
    number = np.full(ns, -1, dtype=np.int64)
    number[keep] = np.arange(len(keep))
    owner = number[np.asarray(into)][node]
    parent_kept = tree[keep]
    parent_kept = np.where(parent_kept < 0, -1, number[np.asarray(into)[parent_kept]])
    return owner.astype(np.int64), parent_kept.astype(np.int64)


cdef int _ascending(const void* a, const void* b) noexcept nogil:
    cdef long long x = (<const long long*>a)[0], y = (<const long long*>b)[0]
    return (x > y) - (x < y)


cdef void _sort(long long* values, Py_ssize_t count) noexcept nogil:
    """Sort in place; most lists are short, and nearly in order."""
    cdef Py_ssize_t i, j
    cdef long long value
    if count > 32:
        qsort(values, count, sizeof(long long), _ascending)
        return
    for i in range(1, count):
        value = values[i]
        j = i
        while j > 0 and values[j - 1] > value:
            values[j] = values[j - 1]
            j -= 1
        values[j] = value


cdef _structure(start, neighbours, order, begin, tree):
    """Rows below each supernode: those of the matrix and those of its children."""
    cdef Py_ssize_t n = len(order), ns = len(tree), s, c, j, p, end, count
    cdef long long[::1] s0 = np.ascontiguousarray(start, dtype=np.int64)
    cdef long long[::1] a = np.ascontiguousarray(neighbours, dtype=np.int64)
    cdef long long[::1] o = np.ascontiguousarray(order, dtype=np.int64)
    cdef long long[::1] first = begin, parent = tree
    position = np.empty(n, dtype=np.int64)
    position[order] = np.arange(n)
    cdef long long[::1] at = position
    cdef long long[::1] seen = np.full(n, -1, dtype=np.int64)
    cdef long long[::1] head = np.full(ns, -1, dtype=np.int64)
    cdef long long[::1] sibling = np.full(ns, -1, dtype=np.int64)
    row_start = np.zeros(ns + 1, dtype=np.int64)
    cdef long long[::1] rs = row_start
    rows = np.empty(max(4 * len(neighbours), 16) + n, dtype=np.int64)
    cdef long long[::1] r = rows
    count = 0
    for s in range(ns):
        if count + n > len(rows):
            rows = np.concatenate((rows, np.empty(len(rows) + n, dtype=np.int64)))
            r = rows
        end = first[s + 1]
        for j in range(first[s], end):
            for p in range(s0[o[j]], s0[o[j] + 1]):
                c = at[a[p]]
                if c >= end and seen[c] != s:
                    seen[c] = s
                    r[count] = c
                    count += 1
        c = head[s]
        while c >= 0:
            for p in range(rs[c], rs[c + 1]):
                j = r[p]
                if j >= end and seen[j] != s:
                    seen[j] = s
                    r[count] = j
                    count += 1
            c = sibling[c]
        rs[s + 1] = count
        if count > rs[s] + 1:
            _sort(&r[rs[s]], count - rs[s])
        if parent[s] >= 0:
            sibling[s] = head[parent[s]]
            head[parent[s]] = s
    return row_start, rows[:count].copy()
