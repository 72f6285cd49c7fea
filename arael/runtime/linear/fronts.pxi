"""The layout of a multifrontal factorisation: sizes, offsets and copies."""

import numpy as np

from libc.stdint cimport int64_t

from arael.runtime.address cimport address, writable
from arael.runtime.linear.lead cimport led

from arael.runtime.linear.subtrees import bundle_subtrees, worth_bundling


cdef class Fronts:
    """Description of the supernodes for the numeric factorisation, in scalars.

    Attributes
    ----------
    columns, below : (ns,) int64
        Columns k and rows r below them of each front.
    first : (ns,) int64
        First column, in the order of elimination.
    tall, low : (ns,) int64
        Leading dimensions of the triangle, and of the panel and the update matrix.
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

    cdef readonly object columns, below, first, tall, low, triangle, panel, alone, together
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
    cdef Py_ssize_t ns = len(supernodes.parent), n = len(supernodes.order), s, p, i
    cdef const int64_t* weight = ints(weights)
    cdef const int64_t* order = ints(supernodes.order)
    cdef const int64_t* begin = ints(supernodes.start)
    cdef const int64_t* row_start = ints(supernodes.row_start)
    cdef const int64_t* rows = ints(supernodes.rows)
    cdef const int64_t* parent = ints(supernodes.parent)
    offsets, update_sizes = np.empty(n + 1, dtype=np.int64), np.empty(ns, dtype=np.int64)
    f.first, f.columns, f.below, f.tall, f.low, f.triangle, f.panel, f.children = (
        np.empty(ns, dtype=np.int64) for _ in range(8)
    )
    f.child_start, costs = np.zeros(ns + 2, dtype=np.int64), np.empty(ns)
    cdef int64_t* offset = filled(offsets)
    cdef int64_t* size = filled(update_sizes)
    cdef int64_t* first = filled(f.first)
    cdef int64_t* columns = filled(f.columns)
    cdef int64_t* below = filled(f.below)
    cdef int64_t* tall = filled(f.tall)
    cdef int64_t* low = filled(f.low)
    cdef int64_t* triangle = filled(f.triangle)
    cdef int64_t* panel = filled(f.panel)
    cdef int64_t* children = filled(f.children)
    cdef int64_t* child_start = filled(f.child_start)
    cdef double* cost = <double*>writable(costs, np.float64)
    cdef int64_t place = 0
    cdef double total = 0
    with nogil:
        offset[0] = 0
        for i in range(n):
            offset[i + 1] = offset[i] + weight[order[i]]
        for s in range(ns):
            first[s] = offset[begin[s]]
            columns[s] = offset[begin[s + 1]] - offset[begin[s]]
            below[s] = 0
            for p in range(row_start[s], row_start[s + 1]):
                below[s] += weight[order[rows[p]]]
            tall[s], low[s] = led(columns[s], pad), led(below[s] + 1, pad)
            # Triangle and panel are adjacent; a vector may overshoot each by `pad`.
            triangle[s] = place
            panel[s] = place + columns[s] * tall[s] + pad
            place += columns[s] * (tall[s] + low[s]) + 2 * pad
            size[s] = below[s] * low[s] + pad if below[s] > 0 else 0
            cost[s] = front_time(columns[s], below[s])
            total += cost[s]
            # Counted one place further on, so that filling moves each start to where it belongs.
            if parent[s] >= 0:
                child_start[parent[s] + 2] += 1
        for s in range(ns):
            child_start[s + 1] += child_start[s]
        for s in range(ns):
            if parent[s] >= 0:
                children[child_start[parent[s] + 1]] = s
                child_start[parent[s] + 1] += 1
    f.storage = place
    f.children, f.child_start = f.children[:child_start[ns]], f.child_start[:ns + 1]
    f.bundle, f.bundles = np.full(ns, -1, dtype=np.int64), 0
    f.alone = f.together = place_updates(supernodes.parent, update_sizes, f.bundle, 0, pad)
    if worth_bundling(ns, total):
        f.bundle, f.bundles = bundle_subtrees(supernodes.parent, costs, f.columns > large)
    if f.bundles:
        f.together = place_updates(
            supernodes.parent, update_sizes, f.bundle, f.bundles, pad
        )
    find_moves(f, supernodes, offset)
    return f


cdef find_moves(Fronts f, supernodes, const int64_t* offset):
    """Find the runs of rows, within the parent and within the whole vector."""
    cdef Py_ssize_t ns = len(supernodes.parent), s, parent, p, j, k, count = 0, strip = 0
    cdef Py_ssize_t here, there, wide, mine, total = len(supernodes.rows)
    cdef const int64_t* up = ints(supernodes.parent)
    cdef const int64_t* rs = ints(supernodes.row_start)
    cdef const int64_t* rows = ints(supernodes.rows)
    cdef const int64_t* begin = ints(supernodes.start)
    numbers = np.empty(total + len(supernodes.order) + 1, dtype=np.int64)
    run, strips = np.empty((total, 3), dtype=np.intc), np.empty((total, 2), dtype=np.intc)
    run_start, strip_start = np.empty(ns + 1, dtype=np.int64), np.empty(ns + 1, dtype=np.int64)
    inside = np.empty(ns, dtype=np.int64)
    cdef int* r = <int*>writable(run, np.intc)          # first row, count, first in the parent
    cdef int* t = <int*>writable(strips, np.intc)       # first scalar, count
    cdef int64_t* r0 = filled(run_start)
    cdef int64_t* r1 = filled(inside)
    cdef int64_t* t0 = filled(strip_start)
    cdef const int64_t* columns = ints(f.columns)
    cdef const int64_t* child_start = ints(f.child_start)
    cdef const int64_t* children = ints(f.children)
    # Runs are grouped by front, but rows of the parent are numbered once for all its children.
    cdef int64_t* place = filled(numbers)
    cdef int64_t* local = place + total
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
            if strip > t0[s] and t[2 * strip - 2] + t[2 * strip - 1] == offset[j]:
                t[2 * strip - 1] += <int>wide
            else:
                t[2 * strip], t[2 * strip + 1] = <int>offset[j], <int>wide
                strip += 1
            there = place[p]
            if (
                count > r0[s] and r[3 * count - 1] + r[3 * count - 2] == there
                and there != columns[parent]
            ):
                r[3 * count - 2] += <int>wide
            else:
                r[3 * count], r[3 * count + 1] = <int>mine, <int>wide
                r[3 * count + 2] = <int>there
                count += 1
            if there < columns[parent]:
                r1[s] = count
            mine += wide
    r0[ns], t0[ns] = count, strip
    f.run_start, f.run_inside, f.strip_start = run_start, inside, strip_start
    f.runs, f.strips = run[:max(count, 1)].copy(), strips[:max(strip, 1)].copy()
