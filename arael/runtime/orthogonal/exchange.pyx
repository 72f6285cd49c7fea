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
from libc.string cimport memset

from arael.runtime.address cimport address, writable

# Sums up to this part of the largest entry of a row are what rounding left of a zero.
cdef double NOTHING = 64 * 2.220446049250313e-16


cdef class _Row:
    """Entries of one dependency at ascending columns."""

    cdef object places, numbers
    cdef const int* at
    cdef const double* value
    cdef Py_ssize_t count

    def __init__(self, places, numbers):
        self.places = np.ascontiguousarray(places, dtype=np.int32)
        self.numbers = np.ascontiguousarray(numbers, dtype=np.float64)
        self.count = len(self.places)
        self.at = <const int*>address(self.places, np.int32)
        self.value = <const double*>address(self.numbers, np.float64, self.count)


cdef void subtract(_Row row, double f, double* sums) noexcept:
    cdef Py_ssize_t i
    for i in range(row.count):
        sums[row.at[i]] += f * row.value[i]


cdef double greatest(Py_ssize_t begin, Py_ssize_t count, const double* sums) noexcept nogil:
    cdef Py_ssize_t i
    cdef double found = 0
    for i in range(begin, count):
        found = max(found, fabs(sums[i]))
    return found


cdef _Row gathered(Py_ssize_t begin, Py_ssize_t count, double* sums, int pivot):
    """Row of the sums with -1 at the pivot; the sums are zero afterwards."""
    cdef double f = -1 / sums[pivot]
    cdef double least = NOTHING * greatest(begin, count, sums)
    cdef Py_ssize_t i, k = 0
    for i in range(begin, count):
        k += i == pivot or fabs(sums[i]) > least
    places, numbers = np.empty(k, np.int32), np.empty(k)
    cdef int* at = <int*>writable(places, np.int32)
    cdef double* value = <double*>writable(numbers, np.float64)
    k = 0
    for i in range(begin, count):
        if i == pivot or fabs(sums[i]) > least:
            at[k] = <int>i
            value[k] = -1.0 if i == pivot else sums[i] * f
            k += 1
    memset(sums + begin, 0, (count - begin) * sizeof(double))
    return _Row(places, numbers)


def reduce_by_priority(rows, int count, double least):
    """Reduce dependencies so that each has one of the least important equations for itself.

    Parameters
    ----------
    rows : list of (columns (k,) int32 ascending, entries (k,) float64)
        Linearly independent; sums of scaled equations that are zero. Columns are equations, the
        least important first.
    count : int, columns
    least : float
        Entries up to this part of the largest of their row are no pivots.

    Returns
    -------
    list of (pivot, columns, entries)
        The row has -1 at its pivot, and 0 at the pivots of others.
    """
    cdef double[::1] table = np.zeros(max(count, 1))
    cdef double* sums = &table[0]
    cdef list of_column = [None] * count
    cdef _Row row, other
    cdef Py_ssize_t c, begin, best
    cdef double largest, f
    cdef bint before = False
    for places, numbers in rows:
        row = _Row(places, numbers)
        if not row.count:
            continue
        subtract(row, 1.0, sums)
        begin = row.at[0]
        largest = greatest(begin, count, sums)
        for c in range(begin, count):
            if fabs(sums[c]) <= least * largest:
                continue
            other = of_column[c]
            if other is None:
                before |= c > begin
                of_column[c] = gathered(begin, count, sums, <int>c)
                break
            # The row that is larger there, in proportion, becomes the pivot: no factor is large.
            f = greatest(0, other.count, other.value)
            if fabs(sums[c]) * f > greatest(begin, count, sums):
                of_column[c] = gathered(begin, count, sums, <int>c)
                subtract(other, 1.0, sums)
                begin = min(begin, <Py_ssize_t>other.at[0])
                other = of_column[c]
                # What is reduced now is another row, of entries of another size.
                largest = greatest(begin, count, sums)
            subtract(other, sums[c], sums)
            begin = min(begin, <Py_ssize_t>other.at[0])
            sums[c] = 0
        else:           # all that is left is small: its largest entry
            best = -1
            for c in range(begin, count):
                if of_column[c] is None and (best < 0 or fabs(sums[c]) > fabs(sums[best])):
                    best = c
            if best < 0:    # it follows from the others, but for rounding
                memset(sums + begin, 0, (count - begin) * sizeof(double))
                continue
            before = True
            of_column[best] = gathered(begin, count, sums, <int>best)
    made = [c for c in range(count - 1, -1, -1) if of_column[c] is not None]
    for c in made:
        of_column[c] = reduced(of_column[c], c, of_column, sums, count)
    if before:      # small entries before a pivot met rows that were not reduced yet
        for c in made:
            of_column[c] = reduced(of_column[c], c, of_column, sums, count)
    return [(c, (<_Row>of_column[c]).places, (<_Row>of_column[c]).numbers) for c in made]


cdef _Row reduced(_Row row, Py_ssize_t pivot, list of_column, double* sums, Py_ssize_t count):
    """Row without entries at the pivots of others."""
    cdef Py_ssize_t i, c, begin = row.at[0]
    cdef _Row other
    subtract(row, 1.0, sums)
    for i in range(row.count):
        c = row.at[i]
        other = of_column[c]
        if c != pivot and other is not None:
            subtract(other, sums[c], sums)
            begin = min(begin, <Py_ssize_t>other.at[0])
            sums[c] = 0
    if not fabs(sums[pivot]) > NOTHING * greatest(begin, count, sums):
        # Nothing but rounding is left at the pivot: dividing by it would leave nothing else.
        memset(sums + begin, 0, (count - begin) * sizeof(double))
        return row
    return gathered(begin, count, sums, <int>pivot)
