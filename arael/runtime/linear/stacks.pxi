"""Order of the fronts, and storage of update matrices until their parents are assembled.

Two stacks, one for even and one for odd depths of the tree: when a front is processed, the updates
of its children are on top of one stack and its own is pushed onto the other, so that nothing has to
be moved when the children are popped.
"""

import numpy as np

from libc.stdint cimport int8_t, int64_t, uint8_t

from arael.runtime.address cimport address, writable


cdef class Stacks:
    """A sequence of fronts and the offsets of their update matrices.

    Attributes
    ----------
    bundles : int
        Number of bundles of subtrees for threads; the fronts above them come last.
    sequence : (ns,) int64
        Fronts, bundle by bundle, children before parents.
    ends : (bundles + 2,) int64
        Bundle b is ``sequence[ends[b]:ends[b + 1]]``, the fronts above are the last.
    update : (ns,) int64
        Offset of the front's update matrix: in the workspace of the thread of the bundle, or, if
        its parent is not in the bundle, in the shared workspace.
    shared : (ns,) bool
        Whether it is the shared one.
    extent, shared_extent : int
        Scalars of both workspaces.
    """

    cdef readonly object sequence, ends, update, shared, bundles, extent, shared_extent


def place_updates(parents, sizes, bundle, Py_ssize_t bundles, Py_ssize_t pad):
    """Place the update matrices of a tree.

    Each bundle, and the fronts above all bundles, starts with both stacks empty, in one workspace;
    only the updates of roots of bundles are stored in the shared one.

    Parameters
    ----------
    parents : (ns,) int64
        Parents come after their children; -1 for roots.
    sizes : (ns,) int64
        Scalars of each update matrix.
    bundle : (ns,) int64
        Bundle of each front, -1 for those above.
    bundles : int
        Their number; 0 if one thread processes the fronts in order.
    pad : int
        Rows are padded to a multiple of this many scalars.

    Returns
    -------
    Stacks
    """
    cdef Stacks found = Stacks()
    cdef Py_ssize_t ns = len(parents), s, own, b
    cdef const int64_t* parent = <const int64_t*>address(parents, np.int64)
    cdef const int64_t* size = <const int64_t*>address(sizes, np.int64, ns)
    cdef const int64_t* bundle_of = <const int64_t*>address(bundle, np.int64, ns)
    found.bundles = bundles
    found.sequence, found.update = np.empty(ns, dtype=np.int64), np.empty(ns, dtype=np.int64)
    found.shared, found.ends = np.zeros(ns, dtype=np.bool_), np.zeros(bundles + 2, dtype=np.int64)
    # Of each bundle and of the fronts above: the tops of both stacks, and the most of each.
    heights, belows = np.zeros(4 * (bundles + 1), dtype=np.int64), np.zeros(ns, dtype=np.int64)
    parities = np.empty(ns, dtype=np.int8)
    cdef int64_t* sequence = filled(found.sequence)
    cdef int64_t* update = filled(found.update)
    cdef uint8_t* shared = <uint8_t*>writable(found.shared, np.bool_)
    cdef int64_t* ends = filled(found.ends)
    cdef int64_t* top = filled(heights)
    cdef int64_t* peak = top + 2 * (bundles + 1)
    # Scalars that the children of each front have on the other stack of its bundle.
    cdef int64_t* below = filled(belows)
    cdef int8_t* parity = <int8_t*>writable(parities, np.int8)
    cdef int64_t waiting = 0, extent = 0, at
    with nogil:
        for s in range(ns - 1, -1, -1):
            parity[s] = 0 if parent[s] < 0 else 1 - parity[parent[s]]
        for s in range(ns):
            own = group_of(bundle_of[s], bundles)
            ends[own + 1] += 1
            if parent[s] >= 0 and group_of(bundle_of[parent[s]], bundles) != own:
                shared[s] = True
                update[s] = waiting
                waiting += size[s]
            else:
                at = 2 * own + parity[s]
                update[s] = top[at]
                top[at] += size[s]
                peak[at] = max(peak[at], top[at])
                if parent[s] >= 0:
                    below[parent[s]] += size[s]
            top[2 * own + 1 - parity[s]] -= below[s]
        for b in range(bundles + 1):
            for s in range(2 * b, 2 * b + 2):
                peak[s] = (peak[s] + pad - 1) // pad * pad
            extent = max(extent, peak[2 * b] + peak[2 * b + 1])
            top[b] = ends[b]                # where the next front of a bundle goes
            ends[b + 1] += ends[b]
        # The second stack is above the first.
        for s in range(ns):
            own = group_of(bundle_of[s], bundles)
            if parity[s] and not shared[s]:
                update[s] += peak[2 * own]
            sequence[top[own]] = s
            top[own] += 1
    found.extent, found.shared_extent = extent, waiting
    return found


cdef inline Py_ssize_t group_of(int64_t bundle, Py_ssize_t bundles) noexcept nogil:
    """Number of a bundle; the fronts above all bundles are the last."""
    return bundle if bundle >= 0 else bundles
