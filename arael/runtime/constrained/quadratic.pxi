"""The step of a solve with exact rows: a convex quadratic problem, solved to rounding.

    min  d'H d / 2 + g'd   with   c + A d = 0 for equalities, c + A d >= 0 for inequalities

By the proximal method of multipliers: for estimates y of the multipliers, the augmented Lagrangian

    d'H d / 2 + g'd + sum_i (max(0, y_i - w_i t_i)^2 / (2 w_i)),   t = c + A d

(equalities without the max) is minimised by Newton's method with an exact line search, which ends
after finitely many steps because the function is piecewise quadratic; then ``y = max(0, y - w t)``.
Each Newton step is one factorisation of ``H + A_W' w A_W`` on the blocks of the model, where W are
the rows in use: the Schur complement of the quasi-definite system ``[H A'; A -1/w]``. With weights
of 1e7 times the curvature of the cost along a row two rounds reach rounding level, and both need
the same factor. R. Rockafellar, Math. Oper. Res. 1, 1976; A. De Marchi, Comput. Optim. Appl. 81,
2022; A. Bambade et al., "PROX-QP", RSS 2022.
"""

import numpy as np

from libc.math cimport INFINITY, fabs
from libc.stdint cimport uint8_t
from libc.stdlib cimport qsort
from libc.string cimport memcpy, memset

from arael.runtime.address cimport writable
from arael.runtime.linear.compiled cimport LinearSolver

cdef int MAX_NEWTON = 60  # of one round
cdef int MAX_ROUNDS = 12
# A step is solved for until rows are violated by less than this part of what counts as none.
cdef double AIMED = 0.01
# A round that leaves more than this part of the distance from the rows is the last: they contradict
# each other, or depend on each other.
cdef double SLOW_ROUND = 0.7


cdef int ascending(const void* a, const void* b) noexcept nogil:
    cdef double x = (<const double*>a)[0], y = (<const double*>b)[0]
    return (x > y) - (x < y)


cdef class Quadratic:
    """The quadratic problem at one linearisation.

    Parameters
    ----------
    rows : RowTable
    solver : LinearSolver, of double precision
    """

    cdef RowTable rows
    cdef LinearSolver solver
    cdef readonly Py_ssize_t factorisations
    cdef object _memory
    cdef Py_ssize_t _count, _n
    cdef const double* _entries
    cdef const double* _values
    cdef const double* _diagonal
    cdef const double* _gradient
    cdef const double* _weights
    cdef double* step            # [n] d
    cdef double* multipliers     # [rows] y
    cdef double* linear          # [rows] t
    cdef bint holds              # whether the linear rows can hold, and do
    cdef double* _along          # [n]
    cdef double* _force          # [n] also H d
    cdef double* _h_along        # [n]
    cdef double* _slope          # [rows]
    cdef double* _pull           # [rows]
    cdef double* _kinks          # [rows]
    cdef double* _system         # [values]
    cdef double* _damped         # [n]
    cdef uint8_t* _active        # [rows] in use
    cdef uint8_t* _factored      # [rows] in use in the factor
    cdef bint _has_factor

    def __init__(self, RowTable rows, LinearSolver solver):
        cdef Py_ssize_t m = rows.count, n = rows.size, v = rows.value_count
        self.rows, self.solver, self._count, self._n = rows, solver, m, n
        self._memory = np.zeros(5 * m + 5 * n + v + m // 4 + 2)
        cdef double* place = <double*>writable(self._memory, np.float64)
        self.multipliers, self.linear = place, place + m
        self._slope, self._pull, self._kinks = place + 2 * m, place + 3 * m, place + 4 * m
        place += 5 * m
        self.step, self._along, self._force = place, place + n, place + 2 * n
        self._h_along, self._damped = place + 3 * n, place + 4 * n
        self._system = place + 5 * n
        self._active = <uint8_t*>(self._system + v)
        self._factored = self._active + m

    cdef void pose(
        self, const double* entries, const double* values, const double* diagonal,
        const double* gradient, const double* weights
    ) noexcept nogil:
        """Take A, H (its diagonal apart, damping included), g and w; they are not copied."""
        self._entries, self._values, self._diagonal = entries, values, diagonal
        self._gradient, self._weights = gradient, weights
        self._has_factor = False

    cdef bint solve(
        self, const double* c, const double* y, const double* tolerance
    ) noexcept nogil:
        """The step, its multipliers and `holds`; False if the matrix is not positive definite.

        Parameters
        ----------
        c : (rows,)
        y : (rows,) estimates of the multipliers to begin with
        tolerance : (rows,) violations of the linear rows that count as none
        """
        cdef Py_ssize_t i
        cdef int round
        cdef bint equal, first = True
        cdef double w, t, apart, ratio, before = INFINITY
        if y != self.multipliers:
            memcpy(self.multipliers, y, self._count * sizeof(double))
        # Rows that were in use, also where a step along them has left them by its curvature.
        for i in range(self._count):
            self._active[i] = self.rows._equal[i] or self.multipliers[i] > 0.0 or c[i] < 0.0
        for round in range(MAX_ROUNDS):
            if not self._minimise(c, first):
                return False
            first, self.holds, ratio = False, True, 0.0
            for i in range(self._count):
                equal, w, t = self.rows._equal[i], max(self._weights[i], 1e-300), self.linear[i]
                self.multipliers[i] -= w * t
                if not equal:
                    self.multipliers[i] = max(0.0, self.multipliers[i])
                # Distance from the row; of an inequality also of its multiplier from 0.
                apart = fabs(t if equal else min(t, self.multipliers[i] / w))
                ratio = max(ratio, apart / tolerance[i])
                if (fabs(t) if equal else -t) > tolerance[i]:
                    self.holds = False
            if ratio <= AIMED or ratio > SLOW_ROUND * before:
                break
            before = ratio
        return True

    cdef bint minimum(self, const double* c) noexcept nogil:
        """The step that makes the augmented Lagrangian for y = 0 least, and the rows there."""
        cdef Py_ssize_t i
        memset(self.multipliers, 0, self._count * sizeof(double))
        for i in range(self._count):
            self._active[i] = self.rows._equal[i] or c[i] < 0.0
        return self._minimise(c, True)

    cdef bint _minimise(self, const double* c, bint first) noexcept nogil:
        """Minimum of the augmented Lagrangian: d, t and the rows in use; as `solve`.

        Steps are solved for as increments, so that rounding errors of an ill-conditioned factor
        shrink with them.
        """
        cdef Py_ssize_t i
        cdef int newton
        cdef bint same, uses
        cdef double length
        if first:
            memset(self.step, 0, self._n * sizeof(double))
            memcpy(self.linear, c, self._count * sizeof(double))
        for newton in range(MAX_NEWTON):
            if not self._factor():
                return False
            for i in range(self._count):
                self._pull[i] = (
                    self.multipliers[i] - self._weights[i] * self.linear[i]
                    if self._active[i] else 0.0)
            if first:
                memset(self._force, 0, self._n * sizeof(double))
            else:
                self.rows.symmetric_product(self._values, self._diagonal, self.step, self._force)
            for i in range(self._n):
                self._along[i] = -self._gradient[i] - self._force[i]
            self.rows.add_transposed(self._entries, self._pull, self._along)
            self.solver.solve(self._along)
            length = 1.0 if first else self._length()
            first = False
            for i in range(self._n):
                self.step[i] += length * self._along[i]
            self.rows.product(self._entries, self.step, self.linear)
            same = True
            for i in range(self._count):
                self.linear[i] += c[i]
                uses = (
                    self.rows._equal[i]
                    or self.multipliers[i] > self._weights[i] * self.linear[i])
                same &= uses == self._active[i]
                self._active[i] = uses
            if same:
                break
        return True

    cdef bint _factor(self) noexcept nogil:
        cdef Py_ssize_t i
        cdef bint same = self._has_factor
        if same:
            for i in range(self._count):
                same &= self._active[i] == self._factored[i]
            if same:
                return True
        memset(self._system, 0, self.rows.value_count * sizeof(double))
        for i in range(self._count):
            self._pull[i] = self._weights[i] if self._active[i] else 0.0
            self._factored[i] = self._active[i]
        self.rows.add_squares(self._entries, self._pull, self._system)
        for i in range(self._n):
            self._damped[i] = self._diagonal[i] + self._system[self.rows.diagonal_at[i]]
        for i in range(self.rows.value_count):
            self._system[i] += self._values[i]
        self.factorisations += 1
        self._has_factor = self.solver.factor(self._system, self._damped) == 0
        return self._has_factor

    cdef double _length(self) noexcept nogil:
        """The minimum of the augmented Lagrangian along a direction: piecewise quadratic.

        `_force` is H d.
        """
        cdef Py_ssize_t i, first = 0, last = 0, middle
        cdef double constant = 0.0, growth = 0.0, kink, low = 0.0, high = 1.0, a, b
        self.rows.product(self._entries, self._along, self._slope)
        self.rows.symmetric_product(self._values, self._diagonal, self._along, self._h_along)
        for i in range(self._n):
            constant += self._along[i] * (self._force[i] + self._gradient[i])
            growth += self._along[i] * self._h_along[i]
        if self._derivative(constant, growth, 1.0) <= 0.0:
            return 1.0
        for i in range(self._count):
            if self.rows._equal[i] or self._weights[i] <= 0.0 or self._slope[i] == 0.0:
                continue
            kink = (self.multipliers[i] / self._weights[i] - self.linear[i]) / self._slope[i]
            if 0.0 < kink < 1.0:
                self._kinks[last] = kink
                last += 1
        qsort(self._kinks, last, sizeof(double), ascending)
        while first < last:  # the piece on which the derivative changes its sign
            middle = (first + last) // 2
            if self._derivative(constant, growth, self._kinks[middle]) <= 0.0:
                low, first = self._kinks[middle], middle + 1
            else:
                high, last = self._kinks[middle], middle
        a = self._derivative(constant, growth, low)
        b = self._derivative(constant, growth, high)
        return low if b <= a else low - a * (high - low) / (b - a)

    cdef double _derivative(self, double constant, double growth, double length) noexcept nogil:
        cdef Py_ssize_t i
        cdef double total = constant + length * growth, pull
        for i in range(self._count):
            pull = self.multipliers[i] - self._weights[i] * (
                self.linear[i] + length * self._slope[i])
            if self.rows._equal[i] or pull > 0.0:
                total -= pull * self._slope[i]
        return total
