"""Symbolic analysis of a sparse QR factorisation of J', the transpose of a matrix J.

The columns of J' are equations, its rows are unknowns. Columns are ordered by minimum degree on the
graph of J J' (two equations are neighbours if they share an unknown). The structure of R is that
of the Cholesky factor of J J'. Columns of equal structure are joined to *fronts*, dense matrices
whose tree is that of the elimination: J. Liu, "On general row merging schemes for sparse Givens
transformations", SIAM J. Sci. Stat. Comput. 7 (1986); T. Davis, "Algorithm 915, SuiteSparseQR",
ACM Trans. Math. Softw. 38 (2011).
"""

import numpy as np

from libc.stdint cimport int64_t
from libc.stdlib cimport free, realloc

from arael.runtime.address cimport address, writable
from arael.runtime.compiled cimport Interruption
from arael.runtime.orthogonal.sorting cimport sort

from arael.runtime.compiled import InterruptedWork
from arael.runtime.linear.planning import minimum_degree

cdef enum:
    CLIQUE = 64     # an unknown in more equations makes them neighbours in a chain, not all pairs


cdef class Analysis:
    """Fronts of the factorisation of J', for one pattern of J.

    Parameters
    ----------
    m, n : int, rows (equations) and columns (unknowns) of J
    indptr : (m + 1,) int32, first entry of each row
    indices : (entries,) int32, columns; duplicates are added up
    interruption : Interruption, optional; `InterruptedWork` is raised if it asks to break off
    """

    def __init__(self, int m, int n, indptr, indices, Interruption interruption=None):
        self.interruption = interruption if interruption is not None else Interruption()
        self.plan.m, self.plan.n, self.kept, self.temporary = m, n, [], []
        cdef const int* start = <const int*>address(indptr, np.int32, m + 1)
        cdef const int* entry = <const int*>address(indices, np.int32, start[m])
        self.transpose(start, entry)
        order = np.ascontiguousarray(self.ordering(start, entry), dtype=np.int32)
        self.symbolic(start, entry, <const int*>address(order, np.int32, m))
        self.temporary = None

    cdef int* ints(self, Py_ssize_t count) except? NULL:
        made = np.zeros(max(count, 1), dtype=np.int32)
        self.kept.append(made)
        return <int*>writable(made, np.int32)

    cdef int* scratch(self, Py_ssize_t count) except? NULL:
        made = np.zeros(max(count, 1), dtype=np.int32)
        self.temporary.append(made)
        return <int*>writable(made, np.int32)

    cdef int64_t* longs(self, Py_ssize_t count) except? NULL:
        made = np.zeros(max(count, 1), dtype=np.int64)
        self.kept.append(made)
        return <int64_t*>writable(made, np.int64)

    cdef transpose(self, const int* start, const int* entry):
        """Entries by unknown."""
        cdef Plan* a = &self.plan
        cdef int i, p, t
        a.by_unknown = self.ints(a.n + 2)
        a.equation = self.ints(start[a.m])
        a.source = self.ints(start[a.m])
        cdef int* to = a.by_unknown + 1      # where the next entry goes: shifted by one
        for p in range(start[a.m]):
            to[entry[p] + 1] += 1
        for i in range(a.n):
            to[i + 1] += to[i]
        for i in range(a.m):
            for p in range(start[i], start[i + 1]):
                t = to[entry[p]]
                to[entry[p]] += 1
                a.equation[t] = i
                a.source[t] = p

    cdef ordering(self, const int* start, const int* entry):
        """Minimum degree on the graph of J J'."""
        cdef Plan* a = &self.plan
        cdef int i, p, t, u, e, m = a.m
        cdef int64_t edges = 0, d, to = 0
        for u in range(a.n):
            d = a.by_unknown[u + 1] - a.by_unknown[u]
            edges += d * (d - 1) if d <= CLIQUE else 2 * d
        neighbours = np.empty(max(edges, 1), dtype=np.int64)
        starts = np.zeros(m + 1, dtype=np.int64)
        seen = np.full(max(m, 1), -1, dtype=np.int32)
        cdef int64_t* neighbour = <int64_t*>writable(neighbours, np.int64)
        cdef int64_t* first = <int64_t*>writable(starts, np.int64)
        cdef int* mark = <int*>writable(seen, np.int32)
        cdef int begin, end, around
        # Where an entry is among those of its unknown, for the neighbours in a chain.
        cdef int* place = self.scratch(start[m])
        for t in range(start[m]):
            place[a.source[t]] = t
        with nogil:
            for i in range(m):
                if self.interruption.look():
                    with gil:
                        raise InterruptedWork
                mark[i] = i
                for p in range(start[i], start[i + 1]):
                    begin, end = a.by_unknown[entry[p]], a.by_unknown[entry[p] + 1]
                    if end - begin > CLIQUE:
                        around = place[p]
                        begin, end = max(begin, around - 1), min(end, around + 2)
                    for t in range(begin, end):
                        e = a.equation[t]
                        if mark[e] != i:
                            mark[e] = i
                            neighbour[to] = e
                            to += 1
                first[i + 1] = to
        ones = np.ones(m, dtype=np.int64)
        return minimum_degree(starts, neighbours[:to], ones, 0, self.interruption)

    cdef symbolic(self, const int* start, const int* entry, const int* order):
        """Elimination tree, structures of the columns of R, fronts."""
        cdef Plan* a = &self.plan
        cdef int m = a.m, n = a.n, k, u, t, i, c, j, p
        cdef int* place = self.scratch(m)          # of an equation in `order`
        cdef int* parent = self.scratch(m)
        cdef int* above = self.scratch(m)          # ancestor, paths compressed
        cdef int* last = self.scratch(n)           # place of the last equation seen of an unknown
        cdef int* leftmost = self.scratch(n)
        cdef int* child = self.scratch(m)
        cdef int* sibling = self.scratch(m)
        cdef int* mark = self.scratch(m)
        cdef int* lefts = self.scratch(m)          # first unknown whose leftmost column it is
        cdef int* next_left = self.scratch(n)
        cdef int64_t* first = self.longs(m + 1)
        cdef int* pattern = NULL
        cdef int* grown
        cdef int64_t capacity = 0, size = 0, s
        for k in range(m):
            place[order[k]] = k
            parent[k] = above[k] = child[k] = mark[k] = lefts[k] = -1
        for u in range(n):
            last[u], leftmost[u] = -1, m
        with nogil:
            for k in range(m):
                for p in range(start[order[k]], start[order[k] + 1]):
                    u = entry[p]
                    if leftmost[u] == m:
                        leftmost[u] = k
                        next_left[u] = lefts[k]
                        lefts[k] = u
                    i = last[u]
                    while i >= 0 and i < k:
                        j = above[i]
                        above[i] = k
                        if j < 0:
                            parent[i] = k
                        i = j
                    last[u] = k
            for k in range(m - 1, -1, -1):
                if parent[k] >= 0:
                    sibling[k] = child[parent[k]]
                    child[parent[k]] = k
        try:
            with nogil:
                for k in range(m):
                    if self.interruption.look():
                        with gil:
                            raise InterruptedWork
                    first[k] = size
                    # At most all columns after k, and no more than what is added.
                    s = 1
                    c = child[k]
                    while c >= 0:
                        s += first[c + 1] - first[c]
                        c = sibling[c]
                    u = lefts[k]
                    while u >= 0:
                        s += a.by_unknown[u + 1] - a.by_unknown[u]
                        u = next_left[u]
                    s = min(s, m - k)
                    if size + s > capacity:
                        capacity = 2 * capacity + s + 4 * m
                        grown = <int*>realloc(pattern, capacity * sizeof(int))
                        if grown == NULL:
                            with gil:
                                raise MemoryError()
                        pattern = grown
                    pattern[size] = k
                    size += 1
                    mark[k] = k
                    c = child[k]
                    while c >= 0:
                        for s in range(first[c] + 1, first[c + 1]):
                            if mark[pattern[s]] != k:
                                mark[pattern[s]] = k
                                pattern[size] = pattern[s]
                                size += 1
                        c = sibling[c]
                    u = lefts[k]
                    while u >= 0:
                        for t in range(a.by_unknown[u], a.by_unknown[u + 1]):
                            j = place[a.equation[t]]
                            if mark[j] != k:
                                mark[j] = k
                                pattern[size] = j
                                size += 1
                        u = next_left[u]
                    first[k + 1] = size
            self.make_fronts(order, parent, child, sibling, first, pattern, leftmost)
        finally:
            free(pattern)

    cdef make_fronts(
        self, const int* order, const int* parent, int* child, int* sibling,
        const int64_t* first, const int* pattern, const int* leftmost,
    ):
        """Postorder, fronts of columns of equal structure, and their places."""
        cdef Plan* a = &self.plan
        cdef int m = a.m, k, c, p, best, before, chosen, q, f, g, count = 0, top, j
        cdef int64_t s, place
        cdef int* post = self.scratch(m)           # place in `order` -> place in postorder
        cdef int* inverse = self.scratch(m)
        cdef int* stack = self.scratch(m)
        cdef int* begin = self.scratch(m)          # first column of a front
        cdef int* end = self.scratch(m)
        cdef int* width = self.scratch(m)          # columns of a front
        # The child with the most columns goes last, next to its parent, to be joined with it.
        for k in range(m):
            best = before = chosen = -1
            p = -1
            c = child[k]
            while c >= 0:
                if first[c + 1] - first[c] >= best:
                    best, chosen, before = <int>(first[c + 1] - first[c]), c, p
                p, c = c, sibling[c]
            if chosen >= 0 and sibling[chosen] >= 0:
                if before >= 0:
                    sibling[before] = sibling[chosen]
                else:
                    child[k] = sibling[chosen]
                sibling[p] = chosen
                sibling[chosen] = -1
        q = 0
        for k in range(m):
            if parent[k] >= 0:
                continue
            top = 0
            stack[0] = k
            while top >= 0:
                c = child[stack[top]]
                if c >= 0:
                    child[stack[top]] = sibling[c]
                    top += 1
                    stack[top] = c
                else:
                    post[stack[top]] = q
                    inverse[q] = stack[top]
                    q += 1
                    top -= 1
        # Neighbours of equal structure make a front. Others are not joined: rows that no later
        # column reads would mix, and so would null vectors that have nothing in common.
        for q in range(m):
            k = inverse[q]
            j = <int>(first[k + 1] - first[k])
            f = count - 1
            if q and parent[inverse[q - 1]] == k and width[f] - (end[f] - begin[f]) == j:
                end[f] = q + 1
                continue
            begin[count], end[count], width[count] = q, q + 1, j
            count += 1
        a.fronts = count
        a.position, a.at, a.front_of = self.ints(m), self.ints(m), self.ints(m)
        for q in range(m):
            a.at[q] = order[inverse[q]]
            a.position[a.at[q]] = q
        a.pivots, a.columns = self.ints(count), self.longs(count + 1)
        for f in range(count):
            a.pivots[f] = end[f] - begin[f]
            a.columns[f + 1] = a.columns[f] + width[f]
            for q in range(begin[f], end[f]):
                a.front_of[q] = f
        a.column = self.ints(a.columns[count])
        a.upward = self.ints(a.columns[count])
        a.parent, a.child = self.ints(count), self.ints(count)
        a.sibling, a.root = self.ints(count), self.ints(count)
        for f in range(count):
            a.child[f] = a.parent[f] = -1
        for f in range(count):
            place = a.columns[f]
            for q in range(begin[f], end[f]):
                a.column[place] = q
                place += 1
            k = inverse[end[f] - 1]
            for s in range(first[k] + 1, first[k + 1]):
                a.column[place] = post[pattern[s]]
                place += 1
            sort(
                a.column + a.columns[f] + a.pivots[f],
                width[f] - a.pivots[f],
            )
            if width[f] > a.pivots[f]:
                a.parent[f] = a.front_of[a.column[a.columns[f] + a.pivots[f]]]
        a.roots = 0
        for f in range(count - 1, -1, -1):
            g = a.parent[f]
            a.root[f] = f if g < 0 else a.root[g]
            if g >= 0:
                a.sibling[f] = a.child[g]
                a.child[g] = f
            else:
                a.roots += 1
        self.place_rows(post, leftmost)

    cdef place_rows(self, const int* post, const int* leftmost):
        """Rows of the fronts, and their places."""
        cdef Plan* a = &self.plan
        cdef int m = a.m, n = a.n, u, f, c, t, lead, count = a.fronts, rows, width
        cdef int64_t s
        cdef int* inside = self.scratch(m)         # column within the present front
        cdef int* to = self.scratch(count + 2)
        a.front_of_unknown = self.ints(n)
        a.local = self.ints(a.by_unknown[n])
        a.own, a.unknown, a.lead = self.ints(count + 1), self.ints(n), self.ints(n)
        for u in range(n):
            a.front_of_unknown[u] = -1
            if leftmost[u] < m:
                a.front_of_unknown[u] = a.front_of[post[leftmost[u]]]
                a.own[a.front_of_unknown[u] + 1] += 1
        for f in range(count):
            a.own[f + 1] += a.own[f]
            to[f] = a.own[f]
        for u in range(n):
            f = a.front_of_unknown[u]
            if f >= 0:
                a.unknown[to[f]] = u
                to[f] += 1
        a.first_row, a.first_cell = self.longs(count + 1), self.longs(count + 1)
        a.widest = a.tallest = 0
        for f in range(count):
            width = <int>(a.columns[f + 1] - a.columns[f])
            for s in range(a.columns[f], a.columns[f + 1]):
                inside[a.column[s]] = <int>(s - a.columns[f])
            for t in range(a.own[f], a.own[f + 1]):
                u = a.unknown[t]
                lead = width
                for s in range(a.by_unknown[u], a.by_unknown[u + 1]):
                    a.local[s] = inside[a.position[a.equation[s]]]
                    lead = min(lead, a.local[s])
                a.lead[t] = lead
            rows = a.own[f + 1] - a.own[f]
            c = a.child[f]
            while c >= 0:
                for s in range(a.columns[c] + a.pivots[c], a.columns[c + 1]):
                    a.upward[s] = inside[a.column[s]]
                # Rows beyond the triangle of a child's other columns are zero.
                rows += <int>min(
                    a.first_row[c + 1] - a.first_row[c],
                    a.columns[c + 1] - a.columns[c] - a.pivots[c],
                )
                c = a.sibling[c]
            a.first_row[f + 1] = a.first_row[f] + rows
            a.first_cell[f + 1] = a.first_cell[f] + <int64_t>rows * width
            a.widest, a.tallest = max(a.widest, width), max(a.tallest, rows)
        a.rows, a.cells = a.first_row[count], a.first_cell[count]
