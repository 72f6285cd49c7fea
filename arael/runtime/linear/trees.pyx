# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
"""Elimination tree of a block pattern in a given order: parents, postorder, column counts."""

import numpy as np


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
    cdef Py_ssize_t n = len(order), i, j, k, p, v
    cdef long long[::1] s = np.ascontiguousarray(start, dtype=np.int64)
    cdef long long[::1] a = np.ascontiguousarray(neighbours, dtype=np.int64)
    cdef long long[::1] o = np.ascontiguousarray(order, dtype=np.int64)
    position = np.empty(n, dtype=np.int64)
    position[order] = np.arange(n)
    cdef long long[::1] at = position
    parents = np.full(n, -1, dtype=np.int64)
    cdef long long[::1] parent = parents
    cdef long long[::1] ancestor = np.full(n, -1, dtype=np.int64)
    for i in range(n):
        v = o[i]
        for p in range(s[v], s[v + 1]):
            j = at[a[p]]
            while j >= 0 and j < i:
                k = ancestor[j]
                ancestor[j] = i
                if k < 0:
                    parent[j] = i
                j = k
    return parents


def postorder(parents, rank=None):
    """Positions of a forest in postorder: each subtree is contiguous, its root last.

    Parameters
    ----------
    parents : (n,) int
    rank : (n,) number, optional
        Children with a higher rank come first; by default they keep their order.

    Returns
    -------
    (n,) int64
    """
    cdef Py_ssize_t n = len(parents), i, v, top, count = 0
    cdef long long[::1] parent = np.ascontiguousarray(parents, dtype=np.int64)
    by = np.arange(n)[::-1] if rank is None else np.argsort(rank, kind="stable")
    # Children are pushed in front of their siblings, so the last one linked is visited first.
    cdef long long[::1] sequence = np.ascontiguousarray(by, dtype=np.int64)
    cdef long long[::1] head = np.full(n + 1, -1, dtype=np.int64)
    cdef long long[::1] sibling = np.full(n, -1, dtype=np.int64)
    order = np.empty(n, dtype=np.int64)
    cdef long long[::1] out = order
    cdef long long[::1] stack = np.empty(n + 1, dtype=np.int64)
    for i in range(n):
        v = sequence[i]
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
    cdef Py_ssize_t n = len(order), i, j, p, v
    cdef long long[::1] s = np.ascontiguousarray(start, dtype=np.int64)
    cdef long long[::1] a = np.ascontiguousarray(neighbours, dtype=np.int64)
    cdef long long[::1] o = np.ascontiguousarray(order, dtype=np.int64)
    cdef long long[::1] parent = np.ascontiguousarray(parents, dtype=np.int64)
    cdef long long[::1] weight = np.ascontiguousarray(weights, dtype=np.int64)
    position = np.empty(n, dtype=np.int64)
    position[order] = np.arange(n)
    cdef long long[::1] at = position
    cdef long long[::1] seen = np.full(n, -1, dtype=np.int64)
    counts = np.zeros(n, dtype=np.int64)
    rows = np.zeros(n, dtype=np.int64)
    cdef long long[::1] c = counts, r = rows
    for i in range(n):
        v = o[i]
        seen[i] = i
        for p in range(s[v], s[v + 1]):
            j = at[a[p]]
            if j > i:
                continue
            while seen[j] != i:
                seen[j] = i
                c[j] += 1
                r[j] += weight[i]
                j = parent[j]
    return counts, rows
