"""Lengths of the rows of the null basis, without the basis.

What a front passes down to a child is a few rows of the null basis. Only lengths of rows are
wanted, so the basis may be rotated: the rows are reduced to a triangle by QR. The time is
then that of a factorisation, however many vectors the basis has.
"""

import numpy as np

from libc.math cimport sqrt
from libc.stdint cimport int64_t

from arael.runtime.address cimport writable

cdef double FREEDOM_NOISE = 64 * 2.220446049250313e-16


def row_lengths(Factor q):
    """Length of each slot's row of the null basis, (n,) float64."""
    cdef const Plan* a = &q.analysis.plan
    cdef int f, c, i, j, k, up, rows, columns, width, passed, s
    cdef int64_t first, total = 0, largest = 1
    found = np.zeros(max(a.n, 1))
    places, widths = np.zeros(max(a.fronts, 1), np.int64), np.zeros(max(a.fronts, 1), np.int32)
    cdef double* length = <double*>writable(found, np.float64)
    # Of each front: rows passed down to it, row by row, and their number of columns.
    cdef int64_t* place = <int64_t*>writable(places, np.int64)
    cdef int* wide = <int*>writable(widths, np.int32)
    for f in range(a.fronts):
        up = q.reduced[f] - q.live[f]
        place[f] = total
        total += <int64_t>up * up
        # Columns of a front: those passed, at most as many as rows, and those that end here.
        largest = max(largest, <int64_t>q.height[f] * q.height[f])
    kept = [np.empty(max(total, 1)), np.empty(largest), np.empty(largest), np.empty(a.tallest + 1)]
    cdef double* above = <double*>writable(kept[0], np.float64)
    cdef double* x = <double*>writable(kept[1], np.float64)
    cdef double* part = <double*>writable(kept[2], np.float64)
    cdef double* tau = <double*>writable(kept[3], np.float64)
    whole = [np.empty(max(a.tallest, 1), np.int32) for _ in range(2)] + [np.empty(a.n, np.int32)]
    cdef int* stair = <int*>writable(whole[0], np.int32)
    cdef int* pivot = <int*>writable(whole[1], np.int32)
    cdef int* row_of = <int*>writable(whole[2], np.int32)
    cdef const int* slot
    cdef double total_
    with nogil:
        for s in range(a.n):
            length[s] = a.front_of_unknown[s] < 0
        for f in range(a.fronts - 1, -1, -1):
            first, rows, passed = a.columns[f], q.height[f], wide[f]
            columns = <int>(a.columns[f + 1] - first)
            width = passed + rows - q.reduced[f]
            if width == 0:
                continue
            slot = q.slot + a.first_row[f]
            for i in range(rows * width):
                x[i] = 0
            for i in range(q.reduced[f] - q.live[f]):
                for j in range(passed):
                    x[<int64_t>j * rows + q.live[f] + i] = above[place[f] + i * passed + j]
            for i in range(rows - q.reduced[f]):
                x[<int64_t>(passed + i) * rows + q.reduced[f] + i] = 1
            for k in range(columns - 1, -1, -1):
                i = q.pivot[first + k]
                if i >= 0:
                    for j in range(width):
                        qr_reflect(
                            q.stair[first + k] - i, q.tau[first + k],
                            q.cell + a.first_cell[f] + <int64_t>k * rows + i + 1,
                            x + <int64_t>j * rows + i,
                        )
            for i in range(rows):
                row_of[slot[i]] = i
                if a.front_of_unknown[slot[i]] == f:
                    total_ = 0
                    for j in range(width):
                        total_ += x[<int64_t>j * rows + i] * x[<int64_t>j * rows + i]
                    length[slot[i]] = sqrt(total_)
            c = a.child[f]
            while c >= 0:
                up = q.reduced[c] - q.live[c]
                for i in range(up):
                    s = row_of[q.slot[a.first_row[c] + q.live[c] + i]]
                    for j in range(width):
                        part[<int64_t>i * width + j] = x[<int64_t>j * rows + s]
                    stair[i] = width
                wide[c] = qr_reduce(width, up, 0, part, stair, pivot, tau, tau, 0.0, FREEDOM_NOISE)
                k = 0       # below these rows are the vectors of the reflections
                for i in range(up):
                    k += pivot[i] >= 0
                    for j in range(wide[c]):
                        above[place[c] + i * wide[c] + j] = (
                            part[<int64_t>i * width + j] if j < k else 0.0
                        )
                c = a.sibling[c]
    return found[:a.n]
