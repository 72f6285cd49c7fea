"""Supernodes of a block factor: runs of columns with equal rows, merged where that is faster."""

import numpy as np

from libc.stdint cimport int64_t
from libc.stdlib cimport qsort
from libc.string cimport memcpy

from arael.runtime.address cimport address, writable


cdef enum:
    CACHE = 128 * 1024      # scalars of the second-level cache


cdef struct Graph:
    Py_ssize_t count
    const int64_t* start
    const int64_t* neighbours
    const int64_t* weights


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
    start, neighbours : int64 arrays
        Undirected graph as in `minimum_degree`.
    weights : (n,) int64
        Scalars of each vertex.
    order : (n,) int64

    Returns
    -------
    Supernodes
    """
    cdef Py_ssize_t n = len(order), ns, kept, s
    cdef Graph graph
    graph.count, graph.start, graph.neighbours = n, ints(start), ints(neighbours)
    graph.weights = ints(weights)
    work = np.empty(10 * n + 2, dtype=np.int64)
    sequence = np.array(order, dtype=np.int64)
    cdef int64_t* eliminated = filled(sequence)
    cdef int64_t* owner = filled(work)
    cdef int64_t* tree = owner + n
    cdef int64_t* rest = tree + n
    gains = np.empty(3 * n, dtype=np.float64)
    cdef double* times = <double*>writable(gains, np.float64)
    with nogil:
        ns = merged(&graph, eliminated, owner, tree, rest, times)
    begins, tree_of = np.empty(n + 1, dtype=np.int64), np.empty(n, dtype=np.int64)
    cdef int64_t* begin = filled(begins)
    cdef int64_t* parent = filled(tree_of)
    gather(n, ns, owner, tree, eliminated, begin, parent, rest)
    row_start, rows = _structure(&graph, ns, eliminated, begin, parent, rest)
    into = joined_siblings(n, ns, begin, parent, row_start, rows, eliminated, graph.weights)
    cdef const int64_t* last
    if into is not None:
        last = ints(into)
        kept = 0
        for s in range(ns):  # numbers of those that are left, in order
            rest[s] = kept
            kept += last[s] == s
        number_columns(ns, last, begin, parent, rest, owner, tree)
        ns = kept
        gather(n, ns, owner, tree, eliminated, begin, parent, rest)
        row_start, rows = _structure(&graph, ns, eliminated, begin, parent, rest)
    return Supernodes(sequence, begins[:ns + 1].copy(), tree_of[:ns].copy(), row_start, rows)


cdef void number_columns(
    Py_ssize_t ns,
    const int64_t* last,
    const int64_t* begin,
    const int64_t* parent,
    const int64_t* number,
    int64_t* owner,
    int64_t* tree,
) noexcept nogil:
    """New number of the supernode of each column, and parents by new numbers."""
    cdef Py_ssize_t s, p
    for s in range(ns):
        for p in range(begin[s], begin[s + 1]):
            owner[p] = number[last[s]]
        if last[s] == s:
            tree[number[s]] = -1 if parent[s] < 0 else number[last[parent[s]]]


cdef Py_ssize_t merged(
    const Graph* graph,
    int64_t* order,
    int64_t* owner,
    int64_t* tree,
    int64_t* work,
    double* times,
) noexcept nogil:
    """Postorder the columns, and merge supernodes into their parents where that is faster.

    Parameters
    ----------
    order : (n,), becomes the postorder
    owner, tree : (n,) filled with the supernode of each column and the parents of supernodes
    work : 8 n + 2 scalars; times : 3 n

    Returns
    -------
    Number of supernodes
    """
    cdef Py_ssize_t n = graph.count, ns = 0, s, c, i, best, previous, best_previous, kept
    cdef int64_t* up = work
    cdef int64_t* at = up + n
    cdef int64_t* below = at + n
    cdef int64_t* post = below + n
    cdef int64_t* free = post + n           # 4 n + 2
    if n == 0:
        return 0
    find_positions(n, order, at)
    find_parents(n, graph.start, graph.neighbours, order, at, up, free)
    find_postorder(n, up, post, free)
    relabel(n, post, order, up, at, free)
    find_positions(n, order, at)
    cdef int64_t* weight = post
    cdef int64_t* counts = free
    for i in range(n):
        weight[i] = graph.weights[order[i]]
    find_counts(n, graph.start, graph.neighbours, order, at, up, weight, counts, below, free + n)
    # First columns of runs in which each has the rows of the next and the next itself.
    cdef int64_t* first = at                # positions are not needed any more
    cdef int64_t* node_of = owner
    cdef int64_t* head = free + n
    cdef int64_t* sibling = head + n
    cdef int64_t* into = sibling + n
    cdef double* k = times
    cdef double* r = k + n
    cdef double* t = r + n
    cdef double gain, most, after
    cdef int64_t p, end
    for i in range(n):
        if i == 0 or up[i - 1] != i or counts[i - 1] != counts[i] + 1:
            first[ns] = i
            ns += 1
        node_of[i] = ns - 1
    for s in range(ns):
        end = first[s + 1] if s + 1 < ns else n
        k[s] = 0
        for i in range(first[s], end):
            k[s] += weight[i]
        r[s] = below[end - 1]
        t[s] = front_time(k[s], r[s])
        tree[s] = -1 if up[end - 1] < 0 else node_of[up[end - 1]]
        head[s] = sibling[s] = -1
        into[s] = s
    for s in range(ns):
        # All children of s were visited and are in its list.
        while True:
            most = 0
            best = best_previous = previous = -1
            c = head[s]
            while c >= 0:
                after = front_time(k[c] + k[s], r[s])
                gain = t[c] + t[s] - after
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
                tree[c] = s
                c = previous
        if tree[s] >= 0:
            sibling[s] = head[tree[s]]
            head[tree[s]] = s
    cdef int64_t* number = head
    kept = 0
    for s in range(ns):
        number[s] = kept
        kept += into[s] == s
    for s in range(ns - 1, -1, -1):
        into[s] = into[into[s]]
    for i in range(n):
        owner[i] = number[into[node_of[i]]]
    for s in range(ns):
        if into[s] == s:
            p = tree[s]
            tree[number[s]] = -1 if p < 0 else number[into[p]]
    return kept


cdef void relabel(
    Py_ssize_t n,
    const int64_t* sequence,
    int64_t* order,
    int64_t* parent,
    int64_t* inverse,
    int64_t* work,
) noexcept nogil:
    """Reorder positions by `sequence`, in `order` and `parent`; `work` is 2 n scalars."""
    cdef Py_ssize_t i
    for i in range(n):
        inverse[sequence[i]] = i
        work[i], work[n + i] = order[i], parent[i]
    for i in range(n):
        order[i] = work[sequence[i]]
        parent[i] = work[n + sequence[i]]
        if parent[i] >= 0:
            parent[i] = inverse[parent[i]]


cdef void gather(
    Py_ssize_t n,
    Py_ssize_t ns,
    const int64_t* owner,
    const int64_t* tree,
    int64_t* order,
    int64_t* begin,
    int64_t* parent,
    int64_t* work,
) noexcept nogil:
    """Order with the columns of each supernode contiguous, supernodes in postorder.

    Within a supernode columns keep their order.

    Parameters
    ----------
    owner : (n,) supernode of each column; tree : (ns,) their parents
    order : (n,), reordered in place
    begin, parent : (ns + 1,) and (ns,), filled
    work : 5 n + 2 scalars
    """
    cdef Py_ssize_t i, s
    cdef int64_t* node_order = work
    cdef int64_t* rank = node_order + n
    cdef int64_t* free = rank + n           # 3 n + 2
    find_postorder(ns, tree, node_order, free)
    for s in range(ns):
        rank[node_order[s]] = s
        begin[s + 1] = 0
    begin[0] = 0
    for s in range(ns):
        parent[rank[s]] = -1 if tree[s] < 0 else rank[tree[s]]
    for i in range(n):
        begin[rank[owner[i]] + 1] += 1
    for s in range(ns):
        begin[s + 1] += begin[s]
    cdef int64_t* place = free
    for s in range(ns):
        place[s] = begin[s]
    cdef int64_t* moved = free + n
    for i in range(n):
        s = rank[owner[i]]
        moved[place[s]] = order[i]
        place[s] += 1
    memcpy(order, moved, n * sizeof(int64_t))


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
    cdef const int64_t* start = ints(nodes.start)
    cdef const int64_t* parent = ints(nodes.parent)
    cdef const int64_t* order = ints(nodes.order)
    cdef const int64_t* row_start = ints(nodes.row_start)
    cdef const int64_t* rows = ints(nodes.rows)
    cdef const int64_t* size = ints(sizes)
    sums = np.zeros(2 * ns)
    cdef double* own = <double*>writable(sums, np.float64)
    cdef double* below = own + ns
    cdef double k, r, flops = 0, time = 0, scattered = 0
    cdef int64_t nnz = 0
    for s in range(ns):
        for p in range(start[s], start[s + 1]):
            own[s] += size[order[p]]
        for p in range(row_start[s], row_start[s + 1]):
            below[s] += size[order[rows[p]]]
        k, r = own[s], below[s]
        nnz += <int64_t>(k * (k + 1) / 2 + k * r)
        flops += k * k * k / 3 + k * k * r + k * r * r
        time += front_time(k, r)
    for s in range(ns):
        p = parent[s]
        if p >= 0 and (own[p] + below[p]) * (own[p] + below[p]) > CACHE:
            scattered += below[s] * max(row_start[s + 1] - row_start[s], 1) / 2.0
    return nnz, flops, time, scattered


cdef int _ascending(const void* a, const void* b) noexcept nogil:
    cdef int64_t x = (<const int64_t*>a)[0], y = (<const int64_t*>b)[0]
    return (x > y) - (x < y)


cdef void _sort(int64_t* values, Py_ssize_t count) noexcept nogil:
    """Sort in place; most lists are short, and nearly in order."""
    cdef Py_ssize_t i, j
    cdef int64_t value
    if count > 32:
        qsort(values, count, sizeof(int64_t), _ascending)
        return
    for i in range(1, count):
        value = values[i]
        j = i
        while j > 0 and values[j - 1] > value:
            values[j] = values[j - 1]
            j -= 1
        values[j] = value


cdef _structure(
    const Graph* graph,
    Py_ssize_t ns,
    const int64_t* order,
    const int64_t* begin,
    const int64_t* parent,
    int64_t* work,
):
    """Rows below each supernode: those of the matrix and those of its children.

    `work` is 4 n scalars.
    """
    cdef Py_ssize_t n = graph.count, s, c, j, p, end, count = 0, room
    cdef int64_t* at = work
    cdef int64_t* seen = at + n
    cdef int64_t* head = seen + n
    cdef int64_t* sibling = head + n
    row_start = np.empty(ns + 1, dtype=np.int64)
    cdef int64_t* rs = filled(row_start)
    room = max(4 * graph.start[n], 16) + n
    rows = np.empty(room, dtype=np.int64)
    cdef int64_t* r = filled(rows)
    find_positions(n, order, at)
    for s in range(n):
        seen[s] = -1
    for s in range(ns):
        head[s] = sibling[s] = -1
    rs[0] = 0
    for s in range(ns):
        if count + n > room:
            rows = np.concatenate((rows, np.empty(room + n, dtype=np.int64)))
            room = len(rows)
            r = filled(rows)
        end = begin[s + 1]
        for j in range(begin[s], end):
            for p in range(graph.start[order[j]], graph.start[order[j] + 1]):
                c = at[graph.neighbours[p]]
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
