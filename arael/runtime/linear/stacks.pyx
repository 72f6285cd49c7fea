# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
"""Who works on which front when, and where update matrices wait for their parents.

Two stacks, one for even and one for odd depths of the tree: when a front is worked on, the updates
of its children are the top of one stack and its own goes onto the other, so that nothing has to be
moved when the children are taken away.
"""

import numpy as np


cdef class Stacks:
    """A sequence of fronts and the places of their update matrices.

    Attributes
    ----------
    bundles : int
        Bundles of subtrees that threads may take; the fronts above them come last.
    sequence : (ns,) int64
        Fronts, bundle by bundle, children before parents.
    ends : (bundles + 2,) int64
        Bundle b is ``sequence[ends[b]:ends[b + 1]]``, the fronts above are the last.
    update : (ns,) int64
        Where the front's update matrix begins: in the room of whoever works on the bundle, or,
        where its parent is not in the bundle, in the room that all share.
    shared : (ns,) bool
        Which of the two.
    room, shared_room : int
        Scalars of both.
    """

    cdef readonly object sequence, ends, update, shared, bundles, room, shared_room


def place_updates(parents, sizes, bundle, Py_ssize_t bundles, Py_ssize_t pad):
    """Place the update matrices of a tree.

    Each bundle, and what is above all of them, finds both stacks empty, one behind the other in the
    same room; only the updates of roots of bundles wait elsewhere.

    Parameters
    ----------
    parents : (ns,) int64
        Parents come after their children; -1 for roots.
    sizes : (ns,) int64
        Scalars of each update matrix.
    bundle : (ns,) int64
        Bundle of each front, -1 for those above.
    bundles : int
        Their number; 0 where one thread goes through the tree from the first front to the last.
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
    # By bundle, what is above them as the last.
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
    found.room, found.shared_room = int(peaks.sum(axis=1).max()), int(waiting)
    return found
