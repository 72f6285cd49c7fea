"""Approximate minimum degree ordering of a weighted graph.

Repeatedly eliminates a vertex of (approximately) minimum external degree. The eliminated part is
stored as a quotient graph of *elements*, the cliques created by eliminations, so that no more
memory is needed than for the original graph. After P. Amestoy, T. Davis, I. Duff, "An approximate
minimum degree ordering algorithm", SIAM J. Matrix Anal. Appl. 17 (1996): approximate external
degrees, element absorption (also aggressive), mass elimination, and indistinguishable vertices
merged into supervariables. Here a vertex is an entity with its number of scalars as weight.
"""

import numpy as np

from libc.math cimport sqrt
from libc.stdint cimport int64_t

from arael.runtime.address cimport address, writable
from arael.runtime.compiled cimport Interruption

from arael.runtime.compiled import InterruptedWork

cdef enum:
    VARIABLE = 0    # still to be eliminated
    ELEMENT = 1     # eliminated, its clique alive
    GONE = 2        # absorbed element, or variable merged into another
    DENSE = 3       # dense vertex, ordered last
    STAYING = 4     # a variable that is never eliminated


cdef class _Graph:
    """Quotient graph: the list of vertex v is `at[start[v]:start[v] + length[v]]`.

    A variable lists the elements it belongs to first (`elements[v]` of them), then its neighbouring
    variables; an element lists its variables.
    """

    cdef object numbers, counters           # the storage of all that follows
    cdef Py_ssize_t n, free, capacity
    cdef int* at
    cdef int* length
    cdef int* elements
    cdef int* weight
    cdef int* degree
    cdef int* kind
    cdef int64_t* start
    cdef int* head                          # doubly linked queues by degree
    cdef int* tail
    cdef int* after
    cdef int* before
    cdef int lightest
    cdef int64_t* mark                      # of an element: outside weight, offset by `stamp`
    cdef int64_t stamp
    cdef int* merged                        # supervariable or element that absorbed it, or -1
    cdef int* bucket                        # hash lists of the new element's variables
    cdef int* chain
    cdef int* code
    cdef int* sequence                      # pivots

    def __init__(self, starts, neighbours, weights):
        cdef Py_ssize_t n = len(weights), edges = len(neighbours), v
        cdef const int64_t* start = <const int64_t*>address(starts, np.int64, n + 1)
        cdef const int64_t* neighbour = <const int64_t*>address(neighbours, np.int64)
        cdef const int64_t* weight = <const int64_t*>address(weights, np.int64)
        cdef int64_t total = 0
        for v in range(n):
            total += weight[v]
        self.n, self.free, self.stamp, self.lightest = n, edges, 1, 0
        self.capacity = edges + edges // 4 + 2 * n + 1
        self.numbers = np.empty(self.capacity + 12 * n + 2 * (total + 1), dtype=np.intc)
        self.counters = np.empty(2 * n, dtype=np.int64)
        self.start = <int64_t*>writable(self.counters, np.int64)
        self.mark = self.start + n
        self.at = <int*>writable(self.numbers, np.intc)
        self.length = self.at + self.capacity
        self.elements = self.length + n
        self.weight = self.elements + n
        self.degree = self.weight + n
        self.kind = self.degree + n
        self.after = self.kind + n
        self.before = self.after + n
        self.merged = self.before + n
        self.bucket = self.merged + n
        self.chain = self.bucket + n
        self.code = self.chain + n
        self.head = self.code + n
        self.tail = self.head + total + 1
        self.sequence = self.tail + total + 1
        for v in range(edges):
            self.at[v] = <int>neighbour[v]
        for v in range(n):
            self.start[v], self.length[v] = start[v], <int>(start[v + 1] - start[v])
            self.weight[v] = <int>weight[v]
            self.elements[v] = self.kind[v] = self.degree[v] = self.code[v] = 0
            self.merged[v] = self.after[v] = self.before[v] = -1
            self.bucket[v] = self.chain[v] = -1
            self.mark[v] = 0
        for v in range(total + 1):
            self.head[v] = self.tail[v] = -1

    cdef inline void unlink(self, int v) noexcept nogil:
        cdef int p = self.before[v], s = self.after[v]
        if s >= 0:
            self.before[s] = p
        else:
            self.tail[self.degree[v]] = p
        if p >= 0:
            self.after[p] = s
        else:
            self.head[self.degree[v]] = s

    cdef inline void link(self, int v) noexcept nogil:
        cdef int d = self.degree[v], p = self.tail[d]
        self.before[v], self.after[v] = p, -1
        if p >= 0:
            self.after[p] = v
        else:
            self.head[d] = v
        self.tail[d] = v
        if d < self.lightest:
            self.lightest = d

    cdef void compress(self) noexcept nogil:
        """Move all live lists to the front of the memory."""
        cdef Py_ssize_t p, to = 0, last
        cdef int v
        # The first entry of each live list is exchanged with the negated vertex itself.
        for v in range(self.n):
            if self.kind[v] != GONE and self.kind[v] != DENSE and self.length[v] > 0:
                p = self.start[v]
                self.start[v] = self.at[p]
                self.at[p] = -v - 1
        p = 0
        while p < self.free:
            if self.at[p] >= 0:
                p += 1
                continue
            v = -self.at[p] - 1
            last = p + self.length[v]
            self.at[to] = <int>self.start[v]
            self.start[v] = to
            to += 1
            p += 1
            while p < last:
                self.at[to] = self.at[p]
                to += 1
                p += 1
        self.free = to


def minimum_degree(
    start, neighbours, weights, Py_ssize_t staying=0, Interruption interruption=None
):
    """Order the vertices of an undirected graph for little fill.

    Parameters
    ----------
    start : (n + 1,) int
    neighbours : (start[n],) int
        Neighbours of vertex v are ``neighbours[start[v]:start[v + 1]]``: both directions of each
        edge, no loops, no repeats.
    weights : (n,) int
        Positive weight of each vertex.
    staying : int
        Number of last vertices that are not eliminated; they only contribute to degrees.
    interruption : Interruption, optional
        Looked at before every pivot.

    Returns
    -------
    (n - staying,) int64
        The vertices in the order of elimination.

    Raises
    ------
    InterruptedWork
        If it is broken off.
    """
    cdef Py_ssize_t n = len(weights)
    if n == staying:
        return np.zeros(0, dtype=np.int64)
    cdef _Graph g = _Graph(
        *(np.ascontiguousarray(one, dtype=np.int64) for one in (start, neighbours, weights))
    )
    cdef Py_ssize_t count
    cdef Interruption stop = interruption if interruption is not None else Interruption()
    # A vertex coupled with nearly all others (a global offset, a calibration) only slows down.
    cdef int dense = <int>max(16.0, 10 * sqrt(n))
    found = np.empty(n, dtype=np.int64)
    cdef int64_t* order = <int64_t*>writable(found, np.int64)
    with nogil:
        count = _eliminate(g, dense, n - staying, stop)
        if count >= 0:
            count = _expand(g, count, n - staying, order)
    if count < 0:
        raise InterruptedWork
    return found if count == n else found[:count].copy()


cdef Py_ssize_t _expand(
    _Graph g, Py_ssize_t pivots, Py_ssize_t stay, int64_t* order
) noexcept nogil:
    """Order with each merged vertex right before the pivot it was eliminated with, dense ones last.

    Returns the number of vertices in it, those before `stay`.
    """
    cdef Py_ssize_t n = g.n, v, k, count = 0
    cdef int* rank = g.code
    cdef int* place = g.head                # pivots + 2: with what follows it is long enough
    cdef int root, link, above
    for v in range(n):
        rank[v] = <int>pivots
    for k in range(pivots):
        rank[g.sequence[k]] = <int>k
    for v in range(n):  # a vertex is merged into the root of its chain
        root = <int>v
        while g.merged[root] >= 0:
            root = g.merged[root]
        link = <int>v
        while g.merged[link] >= 0:  # those after it find the root at once
            above = g.merged[link]
            g.merged[link] = root
            link = above
        g.chain[v] = <int>pivots if g.kind[v] == DENSE else rank[root]
    for k in range(pivots + 2):
        place[k] = 0
    for v in range(stay):
        place[g.chain[v] + 1] += 1
    for k in range(pivots + 1):
        place[k + 1] += place[k]
    for v in range(stay):
        order[place[g.chain[v]]] = v
        place[g.chain[v]] += 1
        count += 1
    return count


cdef Py_ssize_t _eliminate(
    _Graph g, int dense, Py_ssize_t stay, Interruption stop
) noexcept nogil:
    """Eliminate all vertices before `stay`; their number is returned.

    -1 if it is broken off.
    """
    cdef Py_ssize_t count = 0
    cdef int v, pivot, gone, all_left = _prepare(g, dense, stay), left = all_left
    cdef int64_t total = left
    for v in range(stay, g.n):
        if g.kind[v] == STAYING:
            left -= g.weight[v]
    while left > 0:
        if stop.look():
            return -1
        while g.head[g.lightest] < 0:
            g.lightest += 1
        pivot = g.head[g.lightest]
        g.unlink(pivot)
        g.sequence[count] = pivot
        count += 1
        left -= g.weight[pivot]
        all_left -= g.weight[pivot]
        _form(g, pivot)
        _compare(g, pivot)
        gone = _update(g, pivot)
        left -= gone
        all_left -= gone
        g.stamp += total + 1
        _merge(g, pivot)
        _finish(g, pivot, all_left)
    return count


cdef int _prepare(_Graph g, int dense, Py_ssize_t stay) noexcept nogil:
    """Remove dense vertices, list the others by degree; return the weight of the latter."""
    cdef Py_ssize_t p, begin
    cdef int v, u, kept, left = 0
    for v in range(g.n):
        if g.length[v] > dense:
            g.kind[v] = DENSE
        else:
            left += g.weight[v]
            if v >= stay:
                g.kind[v] = STAYING
    for v in range(g.n):
        if g.kind[v] == DENSE:
            continue
        begin = g.start[v]
        kept = 0
        for p in range(begin, begin + g.length[v]):
            u = g.at[p]
            if g.kind[u] != DENSE:
                g.at[begin + kept] = u
                kept += 1
                g.degree[v] += g.weight[u]
        g.length[v] = kept
    g.lightest = left
    for v in range(g.n):
        if g.kind[v] == VARIABLE:
            g.link(v)
    return left


cdef void _form(_Graph g, int pivot) noexcept nogil:
    """Make the pivot an element: all variables adjacent to it, directly or through its elements.

    While the element is processed, its variables have negated weights and are in no degree list.
    The pivot's weight remains negative.
    """
    cdef Py_ssize_t p, q, first, end
    cdef int k, e = -1, u, heavy = 0, parts = g.elements[pivot]
    if parts == 0:
        first = g.start[pivot]          # fits into the pivot's list
    else:
        if g.free + min(<Py_ssize_t>g.degree[pivot], g.n) > g.capacity:
            g.compress()
        first = g.free
    end = first
    g.weight[pivot] = -g.weight[pivot]
    for k in range(parts + 1):
        if k < parts:
            e = g.at[g.start[pivot] + k]
            p = g.start[e]
            q = p + g.length[e]
        else:
            p = g.start[pivot] + parts
            q = g.start[pivot] + g.length[pivot]
        while p < q:
            u = g.at[p]
            p += 1
            if g.weight[u] > 0:
                heavy += g.weight[u]
                g.weight[u] = -g.weight[u]
                g.at[end] = u
                end += 1
                if g.kind[u] == VARIABLE:
                    g.unlink(u)
        if k < parts:
            g.kind[e] = GONE
    if parts > 0:
        g.free = end
    g.kind[pivot] = ELEMENT
    g.start[pivot] = first
    g.length[pivot] = <int>(end - first)
    g.elements[pivot] = 0
    g.degree[pivot] = heavy


cdef void _compare(_Graph g, int pivot) noexcept nogil:
    """For each element e that meets the new one: mark[e] - stamp = weight of e outside of it."""
    cdef Py_ssize_t p, q
    cdef int v, e
    for p in range(g.start[pivot], g.start[pivot] + g.length[pivot]):
        v = g.at[p]
        for q in range(g.start[v], g.start[v] + g.elements[v]):
            e = g.at[q]
            if g.kind[e] != ELEMENT:
                continue
            if g.mark[e] < g.stamp:
                g.mark[e] = g.stamp + g.degree[e]
            g.mark[e] += g.weight[v]            # which is negative


cdef int _update(_Graph g, int pivot) noexcept nogil:
    """Rewrite the lists of the element's variables; return the weight of mass elimination."""
    cdef Py_ssize_t p, q, begin, to, middle
    cdef int v, u, e, d, outside, gone = 0
    cdef unsigned int code
    for p in range(g.start[pivot], g.start[pivot] + g.length[pivot]):
        v = g.at[p]
        begin = g.start[v]
        to = begin
        d = 0
        code = 0
        for q in range(begin, begin + g.elements[v]):
            e = g.at[q]
            if g.kind[e] != ELEMENT:
                continue
            outside = <int>(g.mark[e] - g.stamp)
            if outside > 0:
                d += outside
                code += <unsigned int>e
                g.at[to] = e
                to += 1
            else:
                g.kind[e] = GONE                # absorbed by the new element
        middle = to
        for q in range(begin + g.elements[v], begin + g.length[v]):
            u = g.at[q]
            if g.weight[u] > 0:
                d += g.weight[u]
                code += <unsigned int>u
                g.at[to] = u
                to += 1
        if d == 0 and g.kind[v] == VARIABLE:
            # Coupled only within this element: eliminated with the pivot (mass elimination).
            gone -= g.weight[v]
            g.weight[v] = 0
            g.kind[v] = GONE
            g.merged[v] = pivot
            continue
        # The connection of v with the pivot was removed, so one entry is free. The first variable
        # moves there, the first element to its place, and the new element comes first.
        g.at[to] = g.at[middle]
        g.at[middle] = g.at[begin]
        g.at[begin] = pivot
        g.elements[v] = <int>(middle - begin) + 1
        g.length[v] = <int>(to - begin) + 1
        g.degree[v] = min(g.degree[v], d)
        g.code[v] = <int>(code % <unsigned int>g.n)
        g.chain[v] = g.bucket[g.code[v]]
        g.bucket[g.code[v]] = v
    g.degree[pivot] -= gone
    return gone


cdef void _merge(_Graph g, int pivot) noexcept nogil:
    """Merge variables of the element with equal lists into supervariables."""
    cdef Py_ssize_t p, q
    cdef int v, u, previous, bucket
    cdef bint equal
    for p in range(g.start[pivot], g.start[pivot] + g.length[pivot]):
        if g.weight[g.at[p]] == 0:
            continue
        bucket = g.code[g.at[p]]
        v = g.bucket[bucket]
        g.bucket[bucket] = -1
        while v >= 0:
            if g.chain[v] >= 0:
                for q in range(g.start[v], g.start[v] + g.length[v]):
                    g.mark[g.at[q]] = g.stamp
            previous = v
            u = g.chain[v]
            while u >= 0:
                equal = (
                    g.length[u] == g.length[v] and g.elements[u] == g.elements[v]
                    and g.kind[u] == g.kind[v]
                )
                q = g.start[u]
                while equal and q < g.start[u] + g.length[u]:
                    equal = g.mark[g.at[q]] == g.stamp
                    q += 1
                if equal:
                    g.weight[v] += g.weight[u]
                    g.weight[u] = 0
                    g.kind[u] = GONE
                    g.merged[u] = v
                    g.chain[previous] = g.chain[u]
                else:
                    previous = u
                u = g.chain[u]
            g.stamp += 1
            v = g.chain[v]


cdef void _finish(_Graph g, int pivot, int left) noexcept nogil:
    """Restore the weights and degrees of the element's variables, and list them again."""
    cdef Py_ssize_t p, first = g.start[pivot], to = first, end = first + g.length[pivot]
    cdef int v, w
    for p in range(first, end):
        v = g.at[p]
        if g.weight[v] == 0:
            continue
        w = -g.weight[v]
        g.weight[v] = w
        g.degree[v] = max(min(g.degree[v] + g.degree[pivot] - w, left - w), 0)
        if g.kind[v] == VARIABLE:
            g.link(v)
        g.at[to] = v
        to += 1
    g.length[pivot] = <int>(to - first)
    if to == first:
        g.kind[pivot] = GONE
    if end == g.free:
        g.free = to
