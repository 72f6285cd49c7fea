"""Elimination tree of a block pattern in a given order: parents, postorder, column counts.

The passes (`find_parents` and so on) work on memory of the caller, so that a symbolic factorisation
allocates once. `elimination_tree`, `postorder` and `column_counts` do the same with NumPy arrays.
"""

import numpy as np

from arael.runtime.address cimport address, writable


cdef void find_positions(Py_ssize_t n, const int64_t* order, int64_t* at) noexcept nogil:
    """Position in the order of each vertex."""
    cdef Py_ssize_t i
    for i in range(n):
        at[order[i]] = i


cdef void find_parents(
    Py_ssize_t n,
    const int64_t* start,
    const int64_t* neighbours,
    const int64_t* order,
    const int64_t* at,
    int64_t* parent,
    int64_t* ancestor,
) noexcept nogil:
    """See `elimination_tree`; `ancestor` is n scalars of work."""
    cdef Py_ssize_t i, p, v
    cdef int64_t j, k
    for i in range(n):
        parent[i] = ancestor[i] = -1
    for i in range(n):
        v = order[i]
        for p in range(start[v], start[v + 1]):
            j = at[neighbours[p]]
            while j >= 0 and j < i:
                k = ancestor[j]
                ancestor[j] = i
                if k < 0:
                    parent[j] = i
                j = k


cdef void find_postorder(
    Py_ssize_t n, const int64_t* parent, int64_t* out, int64_t* work
) noexcept nogil:
    """See `postorder`; `work` is 3 n + 2 scalars."""
    cdef int64_t* head = work
    cdef int64_t* stack = head + n + 1
    cdef int64_t* sibling = stack + n + 1
    cdef Py_ssize_t i, top, count = 0
    cdef int64_t v
    for i in range(n + 1):
        head[i] = -1
    # Children are pushed in front of their siblings, so the last one linked is visited first.
    for v in range(n - 1, -1, -1):
        top = parent[v] if parent[v] >= 0 else n
        sibling[v] = head[top]
        head[top] = v
    stack[0] = n
    top = 0
    while top >= 0:
        v = stack[top]
        if head[v] >= 0:
            i = head[v]
            head[v] = sibling[i]
            top += 1
            stack[top] = i
        else:
            if v < n:
                out[count] = v
                count += 1
            top -= 1


cdef void find_counts(
    Py_ssize_t n,
    const int64_t* start,
    const int64_t* neighbours,
    const int64_t* order,
    const int64_t* at,
    const int64_t* parent,
    const int64_t* weight,
    int64_t* counts,
    int64_t* rows,
    int64_t* seen,
) noexcept nogil:
    """See `column_counts`; `seen` is n scalars of work."""
    cdef Py_ssize_t i, p, v
    cdef int64_t j
    for i in range(n):
        seen[i] = -1
        counts[i] = rows[i] = 0
    for i in range(n):
        v = order[i]
        seen[i] = i
        for p in range(start[v], start[v + 1]):
            j = at[neighbours[p]]
            if j > i:
                continue
            while seen[j] != i:
                seen[j] = i
                counts[j] += 1
                rows[j] += weight[i]
                j = parent[j]


cdef const int64_t* ints(array) except? NULL:
    return <const int64_t*>address(array, np.int64)


cdef int64_t* filled(array) except? NULL:
    return <int64_t*>writable(array, np.int64)


def elimination_tree(start, neighbours, order):
    """Parent of each vertex in the elimination tree.

    After J. Liu, "The role of elimination trees in sparse factorization", SIAM J. Matrix Anal.
    Appl. 11 (1990), algorithm 4.2 (path compression by virtual ancestors).

    Parameters
    ----------
    start, neighbours : int arrays
        Undirected graph as in `minimum_degree`.
    order : (n,) int
        Vertices in the order of elimination.

    Returns
    -------
    (n,) int64
        Parent of the vertex at each *position* in the order, as a position; -1 for a root.
    """
    cdef Py_ssize_t n = len(order)
    order = np.ascontiguousarray(order, dtype=np.int64)
    at, parents, work = np.empty(n, np.int64), np.empty(n, np.int64), np.empty(n, np.int64)
    find_positions(n, ints(order), filled(at))
    find_parents(
        n, ints(start), ints(neighbours), ints(order), ints(at), filled(parents), filled(work)
    )
    return parents


def postorder(parents):
    """Positions of a forest in postorder: each subtree is contiguous, its root last.

    Children of one parent keep their order.

    Parameters
    ----------
    parents : (n,) int

    Returns
    -------
    (n,) int64
    """
    cdef Py_ssize_t n = len(parents)
    parents = np.ascontiguousarray(parents, dtype=np.int64)
    order, work = np.empty(n, dtype=np.int64), np.empty(3 * n + 2, dtype=np.int64)
    find_postorder(n, ints(parents), filled(order), filled(work))
    return order


def column_counts(start, neighbours, order, parents, weights):
    """Rows below the diagonal in each column of the factor, as counts and weights.

    Traverses the row subtrees: row i of the factor is non-zero in the columns on the tree paths
    from its entries up to i.

    Parameters
    ----------
    start, neighbours, order
        As in `elimination_tree`.
    parents : (n,) int64
        The tree, by positions in the order.
    weights : (n,) int64
        Scalars of the vertex at each position.

    Returns
    -------
    counts : (n,) int64
        Blocks below the diagonal.
    rows : (n,) int64
        Scalars below the diagonal block.
    """
    cdef Py_ssize_t n = len(order)
    order, parents, weights = (
        np.ascontiguousarray(one, dtype=np.int64) for one in (order, parents, weights)
    )
    at, seen = np.empty(n, np.int64), np.empty(n, np.int64)
    counts, rows = np.empty(n, np.int64), np.empty(n, np.int64)
    find_positions(n, ints(order), filled(at))
    find_counts(
        n,
        ints(start),
        ints(neighbours),
        ints(order),
        ints(at),
        ints(parents),
        ints(weights),
        filled(counts),
        filled(rows),
        filled(seen),
    )
    return counts, rows
