"""Rows by component and in the order of elimination, in counting sorts.

Rows and unknowns that hang together are one component; components stand in the order of their first
row, so that renumbered unknowns change nothing.
"""

import numpy as np

from libc.stdint cimport int32_t, int64_t

from arael.runtime.address cimport address, writable
from arael.runtime.assembly.compiled cimport join, root_of


def neighbours(Py_ssize_t n, indptr, indices, free, taken):
    """Which rows share an unknown: the graph of J J'.

    Parameters
    ----------
    n : int
        Unknowns.
    indptr, indices : (m + 1,), (e,) int32
    free : (n,) uint8
        Unknowns that count.
    taken : (K,) int32
        Rows that count, ascending.

    Returns
    -------
    start, neighbour : (K + 1,), (start[K],) int64
        Neighbours of the k-th of `taken`, without itself, each once.
    """
    cdef Py_ssize_t count = len(taken), k, e, t, entries = 0
    cdef const int32_t* at = <const int32_t*>address(indptr, np.int32)
    cdef const int32_t* of = <const int32_t*>address(indices, np.int32)
    cdef const char* moves = <const char*>address(free, np.uint8, n)
    cdef const int32_t* row = <const int32_t*>address(taken, np.int32)
    starts = np.zeros(n + 2, np.int32)
    cdef int32_t* start = <int32_t*>writable(starts, np.int32)
    for k in range(count):
        for e in range(at[row[k]], at[row[k] + 1]):
            if moves[of[e]]:
                start[of[e] + 2] += 1
                entries += 1
    for k in range(n):
        start[k + 2] += start[k + 1]
    lists = np.empty(entries, np.int32)
    cdef int32_t* listed = <int32_t*>writable(lists, np.int32)
    for k in range(count):
        for e in range(at[row[k]], at[row[k] + 1]):
            if moves[of[e]]:
                listed[start[of[e] + 1]] = <int32_t>k
                start[of[e] + 1] += 1
    # By unknown u, the positions listed[start[u]:start[u + 1]] of rows, ascending.
    firsts = np.zeros(count + 1, np.int64)
    cdef int64_t* first = <int64_t*>writable(firsts, np.int64)
    marks = np.full(count, -1, np.int32)
    cdef int32_t* mark = <int32_t*>writable(marks, np.int32)
    cdef int64_t found = 0
    cdef int64_t* to
    for k in range(count):
        mark[k] = <int32_t>k
        for e in range(at[row[k]], at[row[k] + 1]):
            if moves[of[e]]:
                for t in range(start[of[e]], start[of[e] + 1]):
                    if mark[listed[t]] != k:
                        mark[listed[t]] = <int32_t>k
                        found += 1
        first[k + 1] = found
    others = np.empty(found, np.int64)
    to = <int64_t*>writable(others, np.int64)
    marks[:] = -1
    found = 0
    for k in range(count):
        mark[k] = <int32_t>k
        for e in range(at[row[k]], at[row[k] + 1]):
            if moves[of[e]]:
                for t in range(start[of[e]], start[of[e] + 1]):
                    if mark[listed[t]] != k:
                        mark[listed[t]] = <int32_t>k
                        to[found] = listed[t]
                        found += 1
    return firsts, others


def arranged(Py_ssize_t n, indptr, indices, free, order, links):
    """Positions of rows, and what stands there.

    Parameters
    ----------
    n : int
        Unknowns.
    indptr, indices : (m + 1,), (e,) int32
        Unknowns of each row.
    free : (n,) uint8
        Unknowns that count.
    order : (K,) int64
        Rows that count, in the order of elimination.
    links : None or (indptr, indices)
        Functions whose unknowns are in one component, too.

    Returns
    -------
    tuple of int32 arrays
        The first eleven fields of `Structure`.
    """
    cdef Py_ssize_t m = len(indptr) - 1, count = len(order), k, e, p, c, entries = 0, parts = 0
    cdef const int32_t* at = <const int32_t*>address(indptr, np.int32)
    cdef const int32_t* of = <const int32_t*>address(indices, np.int32)
    cdef const char* moves = <const char*>address(free, np.uint8, n)
    cdef const int64_t* sequence = <const int64_t*>address(order, np.int64)
    cdef const int32_t* link
    cdef const int32_t* linked
    cdef int32_t u, last
    # Unknowns are the first nodes, rows follow: a row has itself alone where no unknown counts.
    parents = np.arange(n + m, dtype=np.int32)
    cdef int32_t* parent = <int32_t*>writable(parents, np.int32)
    for k in range(count):
        for e in range(at[sequence[k]], at[sequence[k] + 1]):
            if moves[of[e]]:
                join(parent, of[e], <int32_t>(n + sequence[k]))
                entries += 1
    if links is not None:
        link = <const int32_t*>address(links[0], np.int32)
        linked = <const int32_t*>address(links[1], np.int32)
        for k in range(len(links[0]) - 1):
            last = -1
            for e in range(link[k], link[k + 1]):
                if moves[linked[e]]:
                    if last >= 0:
                        join(parent, last, linked[e])
                    last = linked[e]
    counted, numbers = np.zeros(m, np.uint8), np.full(n + m, -1, np.int32)
    cdef char* used = <char*>writable(counted, np.uint8)
    cdef int32_t* number = <int32_t*>writable(numbers, np.int32)
    for k in range(count):
        used[sequence[k]] = 1
    for k in range(m):
        if used[k]:
            u = root_of(parent, <int32_t>(n + k))
            if number[u] < 0:
                number[u] = <int32_t>parts
                parts += 1
    component_starts, positions = np.zeros(parts + 1, np.int32), np.empty(count, np.int32)
    cdef int32_t* component = <int32_t*>writable(component_starts, np.int32)
    cdef int32_t* row = <int32_t*>writable(positions, np.int32)
    _begin_runs(component, parts, parent, number, sequence, count, n)
    filled = component_starts[:parts].copy()
    cdef int32_t* fill = <int32_t*>writable(filled, np.int32)
    for k in range(count):
        c = number[root_of(parent, <int32_t>(n + sequence[k]))]
        row[fill[c]] = <int32_t>sequence[k]
        fill[c] += 1
    # Entries by position, then by unknown.
    starts, unknowns, sources = (np.empty(size, np.int32) for size in (count + 1, entries, entries))
    column_starts, of_unknowns = np.zeros(n + 1, np.int32), np.full(n, -1, np.int32)
    cdef int32_t* start = <int32_t*>writable(starts, np.int32)
    cdef int32_t* unknown = <int32_t*>writable(unknowns, np.int32)
    cdef int32_t* source = <int32_t*>writable(sources, np.int32)
    cdef int32_t* column = <int32_t*>writable(column_starts, np.int32)
    cdef int32_t* of_unknown = <int32_t*>writable(of_unknowns, np.int32)
    entries = 0
    for p in range(count):
        start[p] = <int32_t>entries
        c = number[root_of(parent, <int32_t>(n + row[p]))]
        for e in range(at[row[p]], at[row[p] + 1]):
            u = of[e]
            if moves[u]:
                unknown[entries], source[entries] = u, <int32_t>e
                column[u + 1] += 1
                of_unknown[u] = <int32_t>c
                entries += 1
    start[count] = <int32_t>entries
    for k in range(n):
        column[k + 1] += column[k]
    column_positions, column_entries = np.empty(entries, np.int32), np.empty(entries, np.int32)
    cdef int32_t* column_position = <int32_t*>writable(column_positions, np.int32)
    cdef int32_t* column_entry = <int32_t*>writable(column_entries, np.int32)
    filled = column_starts[:n].copy()
    fill = <int32_t*>writable(filled, np.int32)
    for p in range(count):
        for e in range(start[p], start[p + 1]):
            u = unknown[e]
            column_position[fill[u]], column_entry[fill[u]] = <int32_t>p, <int32_t>e
            fill[u] += 1
    unknown_starts = np.zeros(parts + 1, np.int32)
    cdef int32_t* unknown_start = <int32_t*>writable(unknown_starts, np.int32)
    for k in range(n):
        if of_unknown[k] >= 0:
            unknown_start[of_unknown[k] + 1] += 1
    for c in range(parts):
        unknown_start[c + 1] += unknown_start[c]
    unknown_lists = np.empty(unknown_start[parts], np.int32)
    cdef int32_t* listed = <int32_t*>writable(unknown_lists, np.int32)
    filled = unknown_starts[:parts].copy()
    fill = <int32_t*>writable(filled, np.int32)
    for k in range(n):
        if of_unknown[k] >= 0:
            listed[fill[of_unknown[k]]] = <int32_t>k
            fill[of_unknown[k]] += 1
    return (
        positions, starts, unknowns, sources, column_starts, column_positions, column_entries,
        component_starts, unknown_starts, unknown_lists, of_unknowns,
    )  # fmt: skip


cdef void _begin_runs(
    int32_t* component, Py_ssize_t parts, int32_t* parent, const int32_t* number,
    const int64_t* sequence, Py_ssize_t count, Py_ssize_t n,
) noexcept nogil:
    """Where the positions of each component begin."""
    cdef Py_ssize_t k, c
    for k in range(count):
        component[number[root_of(parent, <int32_t>(n + sequence[k]))] + 1] += 1
    for c in range(parts):
        component[c + 1] += component[c]
