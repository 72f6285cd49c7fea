# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
"""Which of the equations that depend on each other are the dependent ones, by priority.

A set of dependencies is a basis of the left null space; any set of columns in which it has full
rank may be declared dependent. Gauss-Jordan elimination that takes its pivots from the least
important equations first finds the set that keeps the most important ones (the greedy algorithm on
the linear matroid, which is optimal: J. Edmonds, "Matroids and the greedy algorithm", Math.
Programming 1 (1971)).
"""

import numpy as np

from libc.math cimport fabs


def reduce_by_priority(double[:, ::1] table, double least):
    """Reduce a table of dependencies in place, its columns from the least important one on.

    Parameters
    ----------
    table : (k, count), each row a dependency: its sum of scaled equations is zero
    least : multipliers up to this part of a row's largest are no pivots

    Returns
    -------
    chosen : (k,) int32, column of each row's dependent equation, where it has -1 and others 0
    """
    cdef Py_ssize_t k = table.shape[0], count = table.shape[1], r, i, j, c, left = k
    cdef double f, best, x
    chosen = np.full(k, -1, dtype=np.int32)
    cdef int[::1] at = chosen
    cdef double[::1] largest = np.zeros(k)
    with nogil:
        for i in range(k):
            for j in range(count):
                largest[i] = max(largest[i], fabs(table[i, j]))
        for c in range(count):
            r, best = -1, least
            for i in range(k):
                if at[i] < 0:
                    x = fabs(table[i, c]) / largest[i]
                    if x > best:
                        r, best = i, x
            if r < 0:
                continue
            at[r] = <int>c
            f = -1 / table[r, c]
            for j in range(count):
                table[r, j] *= f
            table[r, c] = -1
            for i in range(k):
                f = table[i, c]
                if i != r and f != 0:
                    for j in range(count):
                        table[i, j] += f * table[r, j]
                        largest[i] = max(largest[i], fabs(table[i, j]))
                    table[i, c] = 0
            left -= 1
            if left == 0:
                break
    return chosen
