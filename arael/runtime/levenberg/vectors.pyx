# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
"""The vectors of one solve, and what the Levenberg-Marquardt loop does with them.

Threads share passes over many scalars. They are cut by the number of scalars alone, so that sums
have the same bits on any number of threads. Sums are by component: parts are cut into runs of
scalars of one component, whose sums are added in the order of the scalars.
"""

import numpy as np

from libc.math cimport fabs
from libc.stdint cimport int64_t, uint8_t
from libc.string cimport memcpy, memmove, memset

from arael.runtime.address cimport writable
from arael.runtime.parallel.pool cimport Task, distribute
from arael.runtime.assembly.totals cimport Totals

# Doubles of `Sums`.
cdef Py_ssize_t SUMS = sizeof(Sums) // sizeof(double)

# Most parts of a vector.
MOST_PARTS = 16

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
    component : (n,) int array, or None
        Component of each scalar; None: all are of one.
    components : int
        How many there are.

    Attributes
    ----------
    gradient_array, value_array : arrays of `Totals.kept`
    diagonal_array, damped_array, step_array : (n,)
    scale_array : (n,)
        Largest diagonal of J'J since the solve began, which is the square of the scaling of
        variables of Moré, "The Levenberg-Marquardt algorithm: implementation and theory", 1978.
    newton_array, descent_array : (n,)
    """

    def __init__(
        self, Py_ssize_t n, Totals totals, int threads, component=None, Py_ssize_t components=1
    ):
        self.n, self.single, self.threads = n, totals.single, threads
        self.components = components
        self._parts = count_parts(n)
        runs, ends = runs_of(n, component)
        self._run = <int64_t*>writable(runs, np.int64)
        self._ends = <int64_t*>writable(ends, np.int64)
        # One array of doubles for all of these: small problems are solved in microseconds.
        kept = np.zeros((len(runs) + components) * SUMS + 5 * components)
        cdef double* first = <double*>writable(kept, np.float64)
        self._sums = <Sums*>first
        self.sums = self._sums + len(runs)
        self.damping = first + (len(runs) + components) * SUMS
        self.along, self.across = self.damping + components, self.damping + 2 * components
        self.active = <int64_t*>(self.damping + 3 * components)
        self.wanted = <uint8_t*>(self.active + components)
        memset(self.wanted, 1, components)
        self.active_count, self.active_scalars = components, n
        cdef Py_ssize_t k
        for k in range(components):
            self.active[k] = k
        self._direct = len(runs) == components
        self._at = totals.diagonal_at
        self.gradient_array, self.value_array = totals.kept()
        dtype = self.gradient_array.dtype
        (self.diagonal_array, self.damped_array, self.step_array, self.scale_array,
         self.newton_array, self.descent_array, own) = np.zeros((7, max(n, 1)), dtype=dtype)
        self._keep = (totals, own, kept, runs, ends)
        self.gradient = writable(self.gradient_array, dtype)
        self.values = writable(self.value_array, dtype)
        self.step = writable(self.step_array, dtype, n)
        self.damped = writable(self.damped_array, dtype, n)
        self.scale = writable(self.scale_array, dtype, n)
        self.newton = writable(self.newton_array, dtype, n)
        self.descent = writable(self.descent_array, dtype, n)
        self._diagonal = writable(self.diagonal_array, dtype, n)
        self._own = writable(own, dtype, n)

    cdef void take_diagonal(self, double floor) noexcept nogil:
        cdef Py_ssize_t c, k
        self._floor = floor
        self._share(take_part)
        if self._direct:
            return
        for k in range(self.active_count):
            self.sums[self.active[k]].largest = 0
        for k in range(self._ends[self._parts]):
            c = self._run[3 * k + 2]
            self.sums[c].largest = max(self.sums[c].largest, self._sums[k].largest)

    cdef void prepare(self, bint by_scale) noexcept nogil:
        self._by_scale = by_scale
        self._share(prepare_part)

    cdef void products(self) noexcept nogil:
        cdef Py_ssize_t k
        cdef Sums* one
        self._share(product_part)
        if self._direct:
            return
        for k in range(self.active_count):
            one = &self.sums[self.active[k]]
            one.slope = one.length = one.scaled = one.added = 0
        for k in range(self._ends[self._parts]):
            one = &self.sums[self._run[3 * k + 2]]
            one.slope += self._sums[k].slope
            one.length += self._sums[k].length
            one.scaled += self._sums[k].scaled
            one.added += self._sums[k].added

    cdef void keep_newton(self) noexcept nogil:
        cdef Py_ssize_t k, size = 4 if self.single else 8
        cdef const int64_t* run
        for k in range(self._ends[self._parts]):
            run = self._run + 3 * k
            if self.wanted[run[2]]:
                memcpy(<char*>self.newton + run[0] * size, <char*>self.step + run[0] * size,
                       (run[1] - run[0]) * size)

    cdef void take_descent(self) noexcept nogil:
        cdef Py_ssize_t c, k
        self._share(descent_part)
        if self._direct:
            return
        for k in range(self.active_count):
            c = self.active[k]
            self.sums[c].descent_length = self.sums[c].descent_added = 0
        for k in range(self._ends[self._parts]):
            c = self._run[3 * k + 2]
            self.sums[c].descent_length += self._sums[k].descent_length
            self.sums[c].descent_added += self._sums[k].descent_added

    cdef void combine(self) noexcept nogil:
        self._share(combine_part)

    cdef void scaled_gradient(self) noexcept nogil:
        cdef Py_ssize_t k
        for k in range(self.active_count):
            self.sums[self.active[k]].gradient = 0
        if self.single:
            self._scaled(<float*>self.gradient)
        else:
            self._scaled(<double*>self.gradient)

    cdef void leave_out(self, const uint8_t* kept) noexcept nogil:
        cdef Py_ssize_t k, found = 0
        for k in range(self.active_count):
            if kept[self.active[k]]:
                self.active[found] = self.active[k]
                found += 1
        self.active_count = found
        if self.single:
            self._leave_out(<float*>self.step, kept)
        else:
            self._leave_out(<double*>self.step, kept)

    cdef void empty_values(
        self, const int64_t* value_runs, Py_ssize_t count, const uint8_t* kept
    ) noexcept nogil:
        cdef Py_ssize_t k, size = 4 if self.single else 8
        cdef const int64_t* run
        for k in range(count):
            run = value_runs + 3 * k
            if not kept[run[2]]:
                memset(<char*>self.values + run[0] * size, 0, (run[1] - run[0]) * size)

    cdef void _leave_out(self, real* step, const uint8_t* kept) noexcept nogil:
        cdef Py_ssize_t i, k, part, first = 0, end, found = 0
        cdef int64_t* run
        for part in range(self._parts):
            end = self._ends[part + 1]
            for k in range(first, end):
                run = self._run + 3 * k
                if kept[run[2]]:
                    memmove(self._run + 3 * found, run, 3 * sizeof(int64_t))
                    found += 1
                    continue
                self.active_scalars -= run[1] - run[0]
                for i in range(run[0], run[1]):
                    step[i] = 0
                    (<real*>self.damped)[i] = 1
            first, self._ends[part + 1] = end, found

    cdef void _share(self, Task task) noexcept nogil:
        distribute(self.threads, self._parts, task, <void*>self)

    cdef inline Sums* _of_run(self, Py_ssize_t k) noexcept nogil:
        return &self.sums[self._run[3 * k + 2]] if self._direct else &self._sums[k]

    cdef void _take_part(self, Py_ssize_t part, const real* values) noexcept nogil:
        cdef Py_ssize_t i, k, begin, end
        cdef const int64_t* at = self._at
        cdef real* own = <real*>self._own
        cdef real* diagonal = <real*>self._diagonal
        cdef real* scale = <real*>self.scale
        cdef const real* gradient = <const real*>self.gradient
        cdef double floor = self._floor, largest
        for k in range(self._ends[part], self._ends[part + 1]):
            begin, end = self._run[3 * k], self._run[3 * k + 1]
            # Alone in its loop, so that many of these wait for memory at a time.
            for i in range(begin, end):
                own[i] = values[at[i]]
            for i in range(begin, end):
                diagonal[i] = <real>floor if own[i] < floor else own[i]
                scale[i] = diagonal[i] if scale[i] < diagonal[i] else scale[i]
            largest = 0
            for i in range(begin, end):
                largest = max(largest, fabs(<double>gradient[i]))
            self._of_run(k).largest = largest

    cdef void _prepare_part(self, Py_ssize_t part, const real* gradient) noexcept nogil:
        cdef Py_ssize_t i, k, begin, end
        cdef const real* diagonal = <const real*>self._diagonal
        cdef const real* scale = <const real*>self.scale
        cdef real* damped = <real*>self.damped
        cdef real* step = <real*>self.step
        cdef real factor, damping
        for k in range(self._ends[part], self._ends[part + 1]):
            begin, end = self._run[3 * k], self._run[3 * k + 1]
            damping = <real>self.damping[self._run[3 * k + 2]]
            factor = <real>(1 + self.damping[self._run[3 * k + 2]])
            if self._by_scale:
                for i in range(begin, end):
                    damped[i] = diagonal[i] + damping * scale[i]
            else:
                for i in range(begin, end):
                    damped[i] = diagonal[i] * factor
            for i in range(begin, end):
                step[i] = -gradient[i]

    cdef void _product_part(self, Py_ssize_t part, const real* step) noexcept nogil:
        cdef Py_ssize_t i, k
        cdef const real* gradient = <const real*>self.gradient
        cdef const real* damped = <const real*>self.damped
        cdef const real* own = <const real*>self._own
        cdef const real* scale = <const real*>self.scale
        cdef double slope, length, scaled, added, x
        cdef Sums* one
        for k in range(self._ends[part], self._ends[part + 1]):
            slope = length = scaled = added = 0
            for i in range(self._run[3 * k], self._run[3 * k + 1]):
                x = step[i]
                slope += <double>gradient[i] * x
                length += x * x
                scaled += <double>scale[i] * x * x
                added += (<double>damped[i] - <double>own[i]) * x * x
            one = self._of_run(k)
            one.slope, one.length, one.scaled, one.added = slope, length, scaled, added

    cdef void _descent_part(self, Py_ssize_t part, const real* gradient) noexcept nogil:
        cdef Py_ssize_t i, k
        cdef const real* scale = <const real*>self.scale
        cdef const real* damped = <const real*>self.damped
        cdef const real* own = <const real*>self._own
        cdef const real* newton = <const real*>self.newton
        cdef real* descent = <real*>self.descent
        cdef double length, added, c
        cdef Sums* one
        for k in range(self._ends[part], self._ends[part + 1]):
            length = added = 0
            for i in range(self._run[3 * k], self._run[3 * k + 1]):
                c = -<double>gradient[i] / scale[i] if scale[i] > 0 else 0
                descent[i] = <real>c
                length -= <double>gradient[i] * c
                added += (<double>damped[i] - <double>own[i]) * c * <double>newton[i]
            one = self._of_run(k)
            one.descent_length, one.descent_added = length, added

    cdef void _combine_part(self, Py_ssize_t part, real* step) noexcept nogil:
        cdef Py_ssize_t i, k, begin, end, c
        cdef const real* newton = <const real*>self.newton
        cdef const real* descent = <const real*>self.descent
        cdef real along, across
        for k in range(self._ends[part], self._ends[part + 1]):
            begin, end, c = self._run[3 * k], self._run[3 * k + 1], self._run[3 * k + 2]
            along, across = <real>self.along[c], <real>self.across[c]
            for i in range(begin, end):
                step[i] = along * descent[i] + across * newton[i]

    cdef void _scaled(self, const real* gradient) noexcept nogil:
        cdef Py_ssize_t i, k
        cdef const real* diagonal = <const real*>self._diagonal
        cdef double total
        for k in range(self._ends[self._parts]):
            total = self.sums[self._run[3 * k + 2]].gradient
            for i in range(self._run[3 * k], self._run[3 * k + 1]):
                if diagonal[i] > 0:
                    total += <double>gradient[i] * <double>gradient[i] / <double>diagonal[i]
            self.sums[self._run[3 * k + 2]].gradient = total


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


def runs_of(n, component=None):
    """Cut the parts of a vector into runs of scalars of one component.

    Returns
    -------
    runs : (m, 3) int64, begin, end and component of each
    ends : (parts + 1,) int64, runs of each part
    """
    parts = count_parts(n)
    if parts == 1 and component is None:
        return np.array([[0, n, 0]]), np.array([0, 1])
    # Whole cache lines, but for the last part.
    bounds = n * np.arange(parts + 1) // parts // 16 * 16
    bounds[parts] = n
    if component is None:
        runs = np.zeros((parts, 3), dtype=np.int64)
        runs[:, 0], runs[:, 1] = bounds[:parts], bounds[1:]
        return runs, np.arange(parts + 1)
    cuts = np.zeros(n + 1, dtype=bool)
    cuts[1:n] = np.diff(component) != 0
    cuts[bounds] = True
    at = np.flatnonzero(cuts)
    ends = np.searchsorted(at, bounds).astype(np.int64)
    begin, end = at[: len(at) - 1], at[1:]
    return np.stack((begin, end, component[begin]), axis=1).astype(np.int64), ends
