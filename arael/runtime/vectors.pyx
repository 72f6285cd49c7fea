# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
"""The vectors of one solve, and what the Levenberg-Marquardt loop does with them.

Threads share passes over many scalars. They are cut by the number of scalars alone, so that sums
have the same bits on any number of threads.
"""

import numpy as np

from libc.math cimport fabs
from libc.stdint cimport int64_t
from libc.string cimport memcpy

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
    scale_array : (n,)
        Largest diagonal of J'J since the solve began, which is the square of the scaling of
        variables of Moré, "The Levenberg-Marquardt algorithm: implementation and theory", 1978.
    newton_array, descent_array : (n,)
    """

    def __init__(self, Py_ssize_t n, Totals totals, int threads):
        self.n, self.single, self.threads = n, totals.single, threads
        self._parts = count_parts(n)
        self._at = totals.diagonal_at
        self.gradient_array, self.value_array = totals.kept()
        dtype = self.gradient_array.dtype
        (self.diagonal_array, self.damped_array, self.step_array, self.scale_array,
         self.newton_array, self.descent_array, own) = np.zeros((7, max(n, 1)), dtype=dtype)
        self._keep = (totals, own)
        self.gradient = writable(self.gradient_array, dtype)
        self.values = writable(self.value_array, dtype)
        self.step = writable(self.step_array, dtype, n)
        self.damped = writable(self.damped_array, dtype, n)
        self.scale = writable(self.scale_array, dtype, n)
        self.newton = writable(self.newton_array, dtype, n)
        self.descent = writable(self.descent_array, dtype, n)
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

    cdef void prepare(self, double damping, bint by_scale) noexcept nogil:
        self._damping, self._by_scale = damping, by_scale
        self._share(prepare_part)

    cdef Sums products(self) noexcept nogil:
        cdef Py_ssize_t part
        cdef Sums total
        self._share(product_part)
        total = self._sums[0]
        for part in range(1, self._parts):
            total.slope += self._sums[part].slope
            total.length += self._sums[part].length
            total.scaled += self._sums[part].scaled
            total.added += self._sums[part].added
        return total

    cdef void keep_newton(self) noexcept nogil:
        memcpy(self.newton, self.step, self.n * (4 if self.single else 8))

    cdef Descent take_descent(self) noexcept nogil:
        cdef Py_ssize_t part
        cdef Descent total
        self._share(descent_part)
        total = self._descents[0]
        for part in range(1, self._parts):
            total.length += self._descents[part].length
            total.added += self._descents[part].added
        return total

    cdef void combine(self, double along, double across) noexcept nogil:
        self._along, self._across = along, across
        self._share(combine_part)

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
        cdef real* scale = <real*>self.scale
        cdef const real* gradient = <const real*>self.gradient
        cdef double floor = self._floor, largest = 0
        # Alone in its loop, so that many of these wait for memory at a time.
        for i in range(begin, end):
            own[i] = values[at[i]]
        for i in range(begin, end):
            diagonal[i] = <real>floor if own[i] < floor else own[i]
            scale[i] = diagonal[i] if scale[i] < diagonal[i] else scale[i]
        for i in range(begin, end):
            largest = max(largest, fabs(<double>gradient[i]))
        self._largest[part] = largest

    cdef void _prepare_part(self, Py_ssize_t part, const real* gradient) noexcept nogil:
        cdef Py_ssize_t i
        cdef const real* diagonal = <const real*>self._diagonal
        cdef const real* scale = <const real*>self.scale
        cdef real* damped = <real*>self.damped
        cdef real* step = <real*>self.step
        cdef real factor = <real>(1 + self._damping), damping = <real>self._damping
        cdef Py_ssize_t begin = self._end(part - 1) if part else 0, end = self._end(part)
        if self._by_scale:
            for i in range(begin, end):
                damped[i] = diagonal[i] + damping * scale[i]
        else:
            for i in range(begin, end):
                damped[i] = diagonal[i] * factor
        for i in range(begin, end):
            step[i] = -gradient[i]

    cdef void _product_part(self, Py_ssize_t part, const real* step) noexcept nogil:
        cdef Py_ssize_t i
        cdef const real* gradient = <const real*>self.gradient
        cdef const real* damped = <const real*>self.damped
        cdef const real* own = <const real*>self._own
        cdef const real* scale = <const real*>self.scale
        cdef double slope = 0, length = 0, scaled = 0, added = 0, x
        for i in range(self._end(part - 1) if part else 0, self._end(part)):
            x = step[i]
            slope += <double>gradient[i] * x
            length += x * x
            scaled += <double>scale[i] * x * x
            added += (<double>damped[i] - <double>own[i]) * x * x
        self._sums[part].slope, self._sums[part].length = slope, length
        self._sums[part].scaled, self._sums[part].added = scaled, added

    cdef void _descent_part(self, Py_ssize_t part, const real* gradient) noexcept nogil:
        cdef Py_ssize_t i
        cdef const real* scale = <const real*>self.scale
        cdef const real* damped = <const real*>self.damped
        cdef const real* own = <const real*>self._own
        cdef const real* newton = <const real*>self.newton
        cdef real* descent = <real*>self.descent
        cdef double length = 0, added = 0, c
        for i in range(self._end(part - 1) if part else 0, self._end(part)):
            c = -<double>gradient[i] / scale[i] if scale[i] > 0 else 0
            descent[i] = <real>c
            length -= <double>gradient[i] * c
            added += (<double>damped[i] - <double>own[i]) * c * <double>newton[i]
        self._descents[part].length, self._descents[part].added = length, added

    cdef void _combine_part(self, Py_ssize_t part, real* step) noexcept nogil:
        cdef Py_ssize_t i
        cdef const real* newton = <const real*>self.newton
        cdef const real* descent = <const real*>self.descent
        cdef real along = <real>self._along, across = <real>self._across
        for i in range(self._end(part - 1) if part else 0, self._end(part)):
            step[i] = along * descent[i] + across * newton[i]

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


cdef void descent_part(void* of, Py_ssize_t part) noexcept nogil:
    if (<Vectors>of).single:
        (<Vectors>of)._descent_part(part, <const float*>(<Vectors>of).gradient)
    else:
        (<Vectors>of)._descent_part(part, <const double*>(<Vectors>of).gradient)


cdef void combine_part(void* of, Py_ssize_t part) noexcept nogil:
    if (<Vectors>of).single:
        (<Vectors>of)._combine_part(part, <float*>(<Vectors>of).step)
    else:
        (<Vectors>of)._combine_part(part, <double*>(<Vectors>of).step)


def count_parts(n):
    """Parts of a vector of n scalars."""
    return min(MOST_PARTS, n // GRAIN) if n >= 4 * GRAIN else 1
