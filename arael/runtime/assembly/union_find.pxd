# Union-find on an array of parents: the root of a tree is its smallest node.

from libc.stdint cimport int32_t


cdef inline int32_t root_of(int32_t* parent, int32_t node) noexcept nogil:
    """Root of a node's tree; on the way every other node is moved up (path halving)."""
    while parent[node] != node:
        parent[node] = parent[parent[node]]
        node = parent[node]
    return node


cdef inline void join(int32_t* parent, int32_t one, int32_t other) noexcept nogil:
    one, other = root_of(parent, one), root_of(parent, other)
    # The first node of a component is its root, which numbers components in order of their nodes.
    if one < other:
        parent[other] = one
    else:
        parent[one] = other


cdef inline int32_t numbered(int32_t* parent, Py_ssize_t count) noexcept nogil:
    """Put numbers of trees, in order of their first nodes, in place of parents; how many.

    A parent that is -1 before stands for a node that is in no tree: it gets 0.
    """
    cdef Py_ssize_t k
    cdef int32_t found = 0
    # Parents have smaller numbers than their children, so that they have their label by now.
    for k in range(count):
        if parent[k] < 0:
            continue
        if parent[k] == k:
            parent[k] = -1 - found
            found += 1
        else:
            parent[k] = parent[parent[k]]
    for k in range(count):
        parent[k] = -1 - parent[k]
    return found
