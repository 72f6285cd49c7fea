# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
"""The layout of a multifrontal factorisation: sizes, offsets and copies."""

import numpy as np

from arael.runtime.linear.front_time import time_of_front
from arael.runtime.linear.memory import leading
from arael.runtime.linear.stacks import place_updates
from arael.runtime.linear.subtrees import bundle_subtrees


cdef class Fronts:
    """Description of the supernodes for the numeric factorisation, in scalars.

    Attributes
    ----------
    columns, below : (ns,) int64
        Columns k and rows r below them of each front.
    first : (ns,) int64
        First column, in the order of elimination.
    triangle, panel : (ns,) int64
        Offsets of the (k, k) triangle and the (r, k) panel in the storage of the factor. Below the
        panel is a row for the right-hand side.
    storage : int
        Scalars of the factor's storage.
    alone, together : Stacks
        Sequence of the fronts and offsets of their (r, r) update matrices, for one thread and for
        several.
    bundle : (ns,) int64
        Bundle of subtrees that a front belongs to, -1 for the fronts above all of them.
    bundles : int
    child_start, children : int64
        Children of front s: ``children[child_start[s]:child_start[s + 1]]``.
    run_start, run_inside : int64
        Runs of front s: ``run_start[s]:run_start[s + 1]``; those before ``run_inside[s]`` are added
        to columns of the parent, the others to its update matrix.
    runs : (m, 3) int32
        Rows of a front that are consecutive also in its parent: first row, count, first row
        in the parent.
    strip_start : (ns + 1,) int64
    strips : (m, 2) int32
        Consecutive rows of a front in the whole vector: first scalar, count.
    """

    cdef readonly object columns, below, first, triangle, panel, alone, together
    cdef readonly object child_start, children, run_start, run_inside, runs, strip_start, strips
    cdef readonly object storage, bundle, bundles


def plan_fronts(supernodes, weights, Py_ssize_t pad, Py_ssize_t large):
    """Lay out the fronts of a symbolic factor.

    Parameters
    ----------
    supernodes : Supernodes
    weights : (n,) int64
        Scalars of each block, in the original order.
    pad : int
        Rows are padded to a multiple of this many scalars.
    large : int
        Fronts with more columns are factored by BLAS, which may be multithreaded.

    Returns
    -------
    Fronts
    """
    cdef Fronts f = Fronts()
    width = weights[supernodes.order]
    offset = np.concatenate(([0], np.cumsum(width))).astype(np.int64)
    begin, row_start = supernodes.start, supernodes.row_start
    ns = len(supernodes.parent)
    f.first = np.ascontiguousarray(offset[begin[:ns]])
    f.columns = np.diff(offset[begin])
    weight_of_rows = np.concatenate(([0], np.cumsum(width[supernodes.rows])))
    f.below = np.diff(weight_of_rows[row_start])
    tall, low = leading(f.columns, pad), leading(f.below + 1, pad)
    # Triangle and panel of a front are adjacent; a vector may overshoot each by `pad`.
    size = f.columns * (tall + low) + 2 * pad
    place = np.concatenate(([0], np.cumsum(size)))
    f.triangle = np.ascontiguousarray(place[:ns])
    f.panel = f.triangle + f.columns * tall + pad
    f.storage = int(place[ns])
    _family(f, supernodes.parent)
    costs = time_of_front(f.columns, f.below)
    f.bundle, f.bundles = bundle_subtrees(supernodes.parent, costs, f.columns > large)
    sizes = np.where(f.below > 0, f.below * low + pad, 0)
    whole = np.full(ns, -1, dtype=np.int64)
    f.alone = place_updates(supernodes.parent, sizes, whole, 0, pad)
    f.together = f.alone
    if f.bundles:
        f.together = place_updates(supernodes.parent, sizes, f.bundle, f.bundles, pad)
    _moves(f, supernodes, offset)
    return f


cdef _family(Fronts f, parent):
    """List the children of each front."""
    ns = len(parent)
    inner = np.flatnonzero(parent >= 0)
    f.children = inner[np.argsort(parent[inner], kind="stable")].astype(np.int64)
    f.child_start = np.searchsorted(parent[f.children], np.arange(ns + 1)).astype(np.int64)


cdef _moves(Fronts f, supernodes, offsets):
    """Find the runs of rows, within the parent and within the whole vector."""
    cdef Py_ssize_t ns = len(supernodes.parent), s, parent, p, j, k, count = 0, strip = 0
    cdef Py_ssize_t here, there, wide, mine
    cdef long long[::1] up = supernodes.parent, rs = supernodes.row_start, rows = supernodes.rows
    cdef long long[::1] begin = supernodes.start
    cdef long long[::1] offset = offsets
    cdef long long[::1] local = np.full(len(supernodes.order) + 1, -1, dtype=np.int64)
    total = len(supernodes.rows)
    run = np.empty((total, 3), dtype=np.intc)
    strips = np.empty((total, 2), dtype=np.intc)
    run_start = np.zeros(ns + 1, dtype=np.int64)
    inside = np.zeros(ns, dtype=np.int64)
    strip_start = np.zeros(ns + 1, dtype=np.int64)
    cdef int[:, ::1] r = run, t = strips
    cdef long long[::1] r0 = run_start, r1 = inside, t0 = strip_start
    cdef long long[::1] columns = f.columns
    cdef long long[::1] child_start = f.child_start, children = f.children
    # Runs are grouped by front, but rows of the parent are numbered once for all its children.
    cdef long long[::1] place = np.empty(total, dtype=np.int64)
    for parent in range(ns):
        if child_start[parent] == child_start[parent + 1]:
            continue
        for p in range(begin[parent], begin[parent + 1]):
            local[p] = offset[p] - offset[begin[parent]]
        here = columns[parent]
        for p in range(rs[parent], rs[parent + 1]):
            local[rows[p]] = here
            here += offset[rows[p] + 1] - offset[rows[p]]
        for k in range(child_start[parent], child_start[parent + 1]):
            s = children[k]
            for p in range(rs[s], rs[s + 1]):
                place[p] = local[rows[p]]
    for s in range(ns):
        parent = up[s]
        mine = 0
        r0[s] = r1[s] = count
        t0[s] = strip
        for p in range(rs[s], rs[s + 1]):
            j = rows[p]
            wide = offset[j + 1] - offset[j]
            if strip > t0[s] and t[strip - 1, 0] + t[strip - 1, 1] == offset[j]:
                t[strip - 1, 1] += <int>wide
            else:
                t[strip, 0], t[strip, 1] = <int>offset[j], <int>wide
                strip += 1
            there = place[p]
            if (
                count > r0[s] and r[count - 1, 2] + r[count - 1, 1] == there
                and there != columns[parent]
            ):
                r[count - 1, 1] += <int>wide
            else:
                r[count, 0], r[count, 1], r[count, 2] = <int>mine, <int>wide, <int>there
                count += 1
            if there < columns[parent]:
                r1[s] = count
            mine += wide
    r0[ns], t0[ns] = count, strip
    f.run_start, f.run_inside, f.strip_start = run_start, inside, strip_start
    f.runs, f.strips = run[:max(count, 1)].copy(), strips[:max(strip, 1)].copy()
