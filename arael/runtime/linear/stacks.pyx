# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
"""Order of the fronts, and storage of update matrices until their parents are assembled.

Two stacks, one for even and one for odd depths of the tree: when a front is processed, the updates
of its children are on top of one stack and its own is pushed onto the other, so that nothing has to
be moved when the children are popped.
"""

import numpy as np


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
    cdef Py_ssize_t ns = len(parents), s, own, waiting = 0
    cdef long long[::1] parent = parents
    cdef long long[::1] size = np.ascontiguousarray(sizes, dtype=np.int64)
    # By bundle; the fronts above are the last.
    group = np.where(bundle >= 0, bundle, bundles)
    cdef long long[::1] of = np.ascontiguousarray(group, dtype=np.int64)
    parities = np.zeros(ns, dtype=np.int8)
    updates, apart = np.zeros(ns, dtype=np.int64), np.zeros(ns, dtype=np.bool_)
    cdef signed char[::1] parity = parities
    cdef long long[::1] update = updates
    cdef unsigned char[::1] shared = apart.view(np.uint8)
    tops, peaks = np.zeros((bundles + 1, 2), dtype=np.int64), np.zeros((bundles + 1, 2), np.int64)
    cdef long long[:, ::1] top = tops, peak = peaks
    # Scalars that the children of each front have on the other stack of its bundle.
    cdef long long[::1] below = np.zeros(ns, dtype=np.int64)
    for s in range(ns - 1, -1, -1):
        parity[s] = 0 if parent[s] < 0 else 1 - parity[parent[s]]
    for s in range(ns):
        own = of[s]
        if parent[s] >= 0 and of[parent[s]] != own:
            shared[s] = True
            update[s] = waiting
            waiting += size[s]
        else:
            update[s] = top[own, parity[s]]
            top[own, parity[s]] += size[s]
            peak[own, parity[s]] = max(peak[own, parity[s]], top[own, parity[s]])
            if parent[s] >= 0:
                below[parent[s]] += size[s]
        top[own, 1 - parity[s]] -= below[s]
    peaks = -(-peaks // pad) * pad
    updates += np.where(apart | (parities == 0), 0, peaks[group, 0])
    found.bundles = bundles
    found.sequence = np.argsort(group, kind="stable").astype(np.int64)
    found.ends = np.searchsorted(np.sort(group), np.arange(bundles + 2)).astype(np.int64)
    found.update, found.shared = updates, apart
    found.extent, found.shared_extent = int(peaks.sum(axis=1).max()), int(waiting)
    return found
