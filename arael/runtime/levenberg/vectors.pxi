"""The vectors of one solve, and what the Levenberg-Marquardt loop does with them.

Threads share passes over many scalars. They are cut by the number of scalars alone, so that sums
have the same bits on any number of threads. Sums are by component: parts are cut into runs of
scalars of one component, whose sums are added in the order of the scalars.
"""

import numpy as np

from libc.math cimport fabs, isfinite
from libc.stdint cimport int64_t, uint8_t
from libc.string cimport memcpy, memmove, memset

from arael.runtime.address cimport writable
from arael.runtime.parallel.compiled cimport Task, distribute
from arael.runtime.assembly.compiled cimport Totals

from arael.runtime.parallel.vector_parts import count_parts

# Doubles of `Sums`.
cdef Py_ssize_t SUMS = sizeof(Sums) // sizeof(double)

# Part of its entry in the factorised matrix below which a diagonal counts as faded.
cdef double HALF = 0.5


cdef bint is_finite_at(
    Py_ssize_t n, const real* gradient, const real* values, const int64_t* at
) noexcept nogil:
    """Whether values at `at` are positive, and they and the gradient are finite."""
    cdef Py_ssize_t i
    cdef real value
    cdef bint sound = True
    for i in range(n):
        value = values[at[i]]
        sound &= value > 0 and isfinite(<double>value) and isfinite(<double>gradient[i])
    return sound


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
        kept = np.zeros((len(runs) + components) * SUMS + 8 * components)
        cdef double* first = <double*>writable(kept, np.float64)
        self._sums = <Sums*>first
        self.sums = self._sums + len(runs)
        self.damping = first + (len(runs) + components) * SUMS
        self.along, self.across = self.damping + components, self.damping + 2 * components
        self.active = <int64_t*>(self.damping + 3 * components)
        self.back = self.damping + 4 * components
        self.onward = self.damping + 5 * components
        self.wanted = <uint8_t*>(self.damping + 6 * components)
        self.paired = self.wanted + components
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
         self.newton_array, self.descent_array, own, *pair) = np.zeros((10, max(n, 1)), dtype=dtype)
        self._keep = (totals, own, kept, runs, ends, pair)
        self._gradient_before = writable(pair[0], dtype, n)
        self._newton_before = writable(pair[1], dtype, n)
        self._moved = writable(pair[2], dtype, n)
        self.gradient = writable(self.gradient_array, dtype)
        self.values = writable(self.value_array, dtype)
        self.step = writable(self.step_array, dtype, n)
        self.damped = writable(self.damped_array, dtype, n)
        self.scale = writable(self.scale_array, dtype, n)
        self.newton = writable(self.newton_array, dtype, n)
        self.descent = writable(self.descent_array, dtype, n)
        self._diagonal = writable(self.diagonal_array, dtype, n)
        self._own = writable(own, dtype, n)

    def sound(self):
        """Whether the diagonal of J'J is positive, and it and the gradient are finite."""
        if self.single:
            return is_finite_at(
                self.n, <const float*>self.gradient, <const float*>self.values, self._at)
        return is_finite_at(
            self.n, <const double*>self.gradient, <const double*>self.values, self._at)

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

    cdef void turn_back(self) noexcept nogil:
        self._share(turn_back_part)

    cdef void take_faded(self) noexcept nogil:
        cdef Py_ssize_t k
        self._share(faded_part)
        if self._direct:
            return
        for k in range(self.active_count):
            self.sums[self.active[k]].faded = 0
        for k in range(self._ends[self._parts]):
            self.sums[self._run[3 * k + 2]].faded += self._sums[k].faded

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

    cdef void keep_pair(self) noexcept nogil:
        cdef Py_ssize_t k, at, size, item = 4 if self.single else 8
        cdef const int64_t* run
        for k in range(self._ends[self._parts]):
            run = self._run + 3 * k
            if self.paired[run[2]]:
                at, size = run[0] * item, (run[1] - run[0]) * item
                memcpy(<char*>self._gradient_before + at, <char*>self.gradient + at, size)
                memcpy(<char*>self._newton_before + at, <char*>self.newton + at, size)
                memcpy(<char*>self._moved + at, <char*>self.step + at, size)

    cdef void secant_sums(self) noexcept nogil:
        cdef Py_ssize_t k
        cdef Sums* one
        self._share(secant_part)
        if self._direct:
            return
        for k in range(self.active_count):
            one = &self.sums[self.active[k]]
            one.secant_moved = one.secant_change = one.secant_newton = one.secant_solved = 0
        for k in range(self._ends[self._parts]):
            one = &self.sums[self._run[3 * k + 2]]
            if self.paired[self._run[3 * k + 2]]:
                one.secant_moved += self._sums[k].secant_moved
                one.secant_change += self._sums[k].secant_change
                one.secant_newton += self._sums[k].secant_newton
                one.secant_solved += self._sums[k].secant_solved

    cdef void add_pair(self) noexcept nogil:
        self._share(add_pair_part)

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

    cdef void _turn_back_part(self, Py_ssize_t part, const real* gradient) noexcept nogil:
        cdef Py_ssize_t i, k
        cdef real* step = <real*>self.step
        for k in range(self._ends[part], self._ends[part + 1]):
            for i in range(self._run[3 * k], self._run[3 * k + 1]):
                step[i] = -gradient[i]

    cdef void _faded_part(self, Py_ssize_t part, const real* gradient) noexcept nogil:
        cdef Py_ssize_t i, k
        cdef const real* damped = <const real*>self.damped
        cdef const real* own = <const real*>self._own
        cdef const real* step = <const real*>self.step
        cdef double total
        for k in range(self._ends[part], self._ends[part + 1]):
            total = 0
            for i in range(self._run[3 * k], self._run[3 * k + 1]):
                # NaN if both are zero, which proves nothing.
                if not own[i] >= HALF * damped[i] and gradient[i] != 0:
                    total += (
                        fabs(<double>gradient[i] * step[i]) * <double>damped[i] / <double>own[i])
            self._of_run(k).faded = total

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

    cdef void _secant_part(self, Py_ssize_t part, const real* gradient) noexcept nogil:
        cdef Py_ssize_t i, k
        cdef const real* before = <const real*>self._gradient_before
        cdef const real* earlier = <const real*>self._newton_before
        cdef const real* moved = <const real*>self._moved
        cdef const real* newton = <const real*>self.newton
        cdef double y, sg, sy, yn, yu
        cdef Sums* one
        for k in range(self._ends[part], self._ends[part + 1]):
            if not self.paired[self._run[3 * k + 2]]:
                continue
            sg = sy = yn = yu = 0
            for i in range(self._run[3 * k], self._run[3 * k + 1]):
                y = <double>gradient[i] - <double>before[i]
                sg += <double>moved[i] * gradient[i]
                sy += <double>moved[i] * y
                yn += <double>newton[i] * y
                yu += (<double>earlier[i] - <double>newton[i]) * y
            one = self._of_run(k)
            one.secant_moved, one.secant_change = sg, sy
            one.secant_newton, one.secant_solved = yn, yu

    cdef void _add_pair_part(self, Py_ssize_t part, real* step) noexcept nogil:
        cdef Py_ssize_t i, k, c
        cdef const real* earlier = <const real*>self._newton_before
        cdef const real* moved = <const real*>self._moved
        cdef real back, onward
        for k in range(self._ends[part], self._ends[part + 1]):
            c = self._run[3 * k + 2]
            if not self.paired[c]:
                continue
            back, onward = <real>self.back[c], <real>self.onward[c]
            for i in range(self._run[3 * k], self._run[3 * k + 1]):
                step[i] += back * earlier[i] + onward * moved[i]

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


cdef void turn_back_part(void* of, Py_ssize_t part) noexcept nogil:
    if (<Vectors>of).single:
        (<Vectors>of)._turn_back_part(part, <const float*>(<Vectors>of).gradient)
    else:
        (<Vectors>of)._turn_back_part(part, <const double*>(<Vectors>of).gradient)


cdef void faded_part(void* of, Py_ssize_t part) noexcept nogil:
    if (<Vectors>of).single:
        (<Vectors>of)._faded_part(part, <const float*>(<Vectors>of).gradient)
    else:
        (<Vectors>of)._faded_part(part, <const double*>(<Vectors>of).gradient)


cdef void secant_part(void* of, Py_ssize_t part) noexcept nogil:
    if (<Vectors>of).single:
        (<Vectors>of)._secant_part(part, <const float*>(<Vectors>of).gradient)
    else:
        (<Vectors>of)._secant_part(part, <const double*>(<Vectors>of).gradient)


cdef void add_pair_part(void* of, Py_ssize_t part) noexcept nogil:
    if (<Vectors>of).single:
        (<Vectors>of)._add_pair_part(part, <float*>(<Vectors>of).step)
    else:
        (<Vectors>of)._add_pair_part(part, <double*>(<Vectors>of).step)


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
