# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
"""The vectors of one solve, and what the Levenberg-Marquardt loop does with them.

Threads share passes over many scalars. They are cut by the number of scalars alone, so that sums
have the same bits on any number of threads.
"""

import numpy as np

from libc.math cimport fabs
from libc.stdint cimport int64_t

from arael.runtime.address cimport writable
from arael.runtime.pool cimport Task, distribute
from arael.runtime.totals cimport Totals

#: Fewest scalars of a part; a vector of less than four of these is one part.
GRAIN = 8192


cdef class Vectors:
    """Gradient, diagonal and step of a system.

    Parameters
    ----------
    n : int
        Scalars of the system.
    totals : Totals
        Has the arrays of gradient and values, and where the diagonal is.
    threads : int

    Attributes
    ----------
    gradient_array, value_array : arrays of `Totals.kept`
    diagonal_array, damped_array, step_array : (n,)
    """

    def __init__(self, Py_ssize_t n, Totals totals, int threads):
        self.n, self.single, self.threads = n, totals.single, threads
        self._parts = count_parts(n)
        self._at = totals.diagonal_at
        self.gradient_array, self.value_array = totals.kept()
        dtype = self.gradient_array.dtype
        self.diagonal_array, self.damped_array, self.step_array, own = (
            np.zeros(max(n, 1), dtype=dtype) for _ in range(4)
        )
        self._keep = (totals, own)
        self.gradient = writable(self.gradient_array, dtype)
        self.values = writable(self.value_array, dtype)
        self.step = writable(self.step_array, dtype, n)
        self.damped = writable(self.damped_array, dtype, n)
        self._diagonal = writable(self.diagonal_array, dtype, n)
        self._own = writable(own, dtype, n)

    cdef double take_diagonal(self, double floor) noexcept nogil:
        cdef Py_ssize_t part
        cdef double largest = 0
        self._floor = floor
        self._share(take_part)
        for part in range(self._parts):
            largest = max(largest, self._largest[part])
        return largest

    cdef void prepare(self, double damping) noexcept nogil:
        self._factor = 1 + damping
        self._share(prepare_part)

    cdef Sums products(self) noexcept nogil:
        cdef Py_ssize_t part
        cdef Sums total
        self._share(product_part)
        total = self._sums[0]
        for part in range(1, self._parts):
            total.slope += self._sums[part].slope
            total.length += self._sums[part].length
            total.added += self._sums[part].added
        return total

    cdef double scaled_gradient(self) noexcept nogil:
        if self.single:
            return self._scaled(<float*>self.gradient)
        return self._scaled(<double*>self.gradient)

    cdef void _share(self, Task task) noexcept nogil:
        distribute(self.threads, self._parts, task, <void*>self)

    cdef Py_ssize_t _end(self, Py_ssize_t part) noexcept nogil:
        """Where a part ends, at a whole number of cache lines but for the last."""
        return self.n if part + 1 == self._parts else self.n * (part + 1) // self._parts // 16 * 16

    cdef void _take_part(self, Py_ssize_t part, const real* values) noexcept nogil:
        cdef Py_ssize_t i, begin = self._end(part - 1) if part else 0, end = self._end(part)
        cdef const int64_t* at = self._at
        cdef real* own = <real*>self._own
        cdef real* diagonal = <real*>self._diagonal
        cdef const real* gradient = <const real*>self.gradient
        cdef double floor = self._floor, largest = 0
        # Alone in its loop, so that many of these wait for memory at a time.
        for i in range(begin, end):
            own[i] = values[at[i]]
        for i in range(begin, end):
            diagonal[i] = <real>floor if own[i] < floor else own[i]
        for i in range(begin, end):
            largest = max(largest, fabs(<double>gradient[i]))
        self._largest[part] = largest

    cdef void _prepare_part(self, Py_ssize_t part, const real* gradient) noexcept nogil:
        cdef Py_ssize_t i
        cdef const real* diagonal = <const real*>self._diagonal
        cdef real* damped = <real*>self.damped
        cdef real* step = <real*>self.step
        cdef real factor = <real>self._factor
        for i in range(self._end(part - 1) if part else 0, self._end(part)):
            damped[i] = diagonal[i] * factor
            step[i] = -gradient[i]

    cdef void _product_part(self, Py_ssize_t part, const real* step) noexcept nogil:
        cdef Py_ssize_t i
        cdef const real* gradient = <const real*>self.gradient
        cdef const real* damped = <const real*>self.damped
        cdef const real* own = <const real*>self._own
        cdef double slope = 0, length = 0, added = 0, x
        for i in range(self._end(part - 1) if part else 0, self._end(part)):
            x = step[i]
            slope += <double>gradient[i] * x
            length += x * x
            added += (<double>damped[i] - <double>own[i]) * x * x
        self._sums[part].slope, self._sums[part].length = slope, length
        self._sums[part].added = added

    cdef double _scaled(self, const real* gradient) noexcept nogil:
        cdef Py_ssize_t i
        cdef const real* diagonal = <const real*>self._diagonal
        cdef double total = 0
        for i in range(self.n):
            if diagonal[i] > 0:
                total += <double>gradient[i] * <double>gradient[i] / <double>diagonal[i]
        return total


cdef void take_part(void* of, Py_ssize_t part) noexcept nogil:
    if (<Vectors>of).single:
        (<Vectors>of)._take_part(part, <const float*>(<Vectors>of).values)
    else:
        (<Vectors>of)._take_part(part, <const double*>(<Vectors>of).values)


cdef void prepare_part(void* of, Py_ssize_t part) noexcept nogil:
    if (<Vectors>of).single:
        (<Vectors>of)._prepare_part(part, <const float*>(<Vectors>of).gradient)
    else:
        (<Vectors>of)._prepare_part(part, <const double*>(<Vectors>of).gradient)


cdef void product_part(void* of, Py_ssize_t part) noexcept nogil:
    if (<Vectors>of).single:
        (<Vectors>of)._product_part(part, <const float*>(<Vectors>of).step)
    else:
        (<Vectors>of)._product_part(part, <const double*>(<Vectors>of).step)


def count_parts(n):
    """Parts of a vector of n scalars."""
    return min(MOST_PARTS, n // GRAIN) if n >= 4 * GRAIN else 1
