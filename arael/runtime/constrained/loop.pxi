"""The loop of a solve with exact rows: sequential quadratic programming on Gauss-Newton blocks.

With ``f = |r|^2 / 2`` and rows c, each step solves the quadratic problem of `quadratic.pxi` at the
state: ``H = J'J`` of the cost and the second derivatives of the rows times their multipliers (and
of the residuals, where Gauss-Newton converges slowly), damped where that is not positive definite
along the rows or where the last step failed. A step is accepted if it lowers the exact penalty
function ``f + sum_i nu_i v_i`` of the violations v as promised, if necessary after a second-order
correction. J. Nocedal, S. Wright, "Numerical Optimization", 2nd ed., 2006, chapter 18.

Where the linear rows contradict each other, steps lower the violations alone, until they can be
removed, or are at a minimum: then the problem is infeasible there.
"""

import numpy as np

from libc.math cimport INFINITY, NAN, fabs, isfinite, sqrt
from libc.stdint cimport uint8_t
from libc.string cimport memcpy, memset

from arael.runtime.address cimport writable
from arael.runtime.evaluation.compiled cimport ComponentLanes, Evaluation
from arael.runtime.levenberg.clock cimport seconds
from arael.runtime.levenberg.compiled cimport (
    ABORTED, CONVERGED, COST_THRESHOLD, MAX_ITERATIONS, OBSERVER_TERMINATED, RUNNING, STALLED,
    STATUS_COUNT, TIME_LIMIT, Settings, Supervised, settings_of,
)
from arael.runtime.linear.compiled cimport LinearSolver

from arael.runtime.levenberg.compiled import STATUSES

# Besides the ends of the ordinary loop.
cdef int INFEASIBLE = STATUS_COUNT

# Weight of a row relative to the curvature of the cost along it. Below 1e5 more rounds are needed,
# beyond 1e10 rounding of the factor shows in steps along the rows.
cdef double WEIGHT = 1e7
cdef double FIRST_DAMPING = 1e-4
cdef double LEAST_DAMPING = 1e-9
# Damping at which violations alone are lowered, or the solve has stalled.
cdef double MAX_DAMPING = 1e10
# Convergence of Gauss-Newton slower than this per step takes second derivatives of residuals too.
cdef double SLOW = 0.2
# More colours than this make second derivatives of the residuals more expensive than more steps.
cdef int MAX_COLOURS = 64
# Steps in a row within the noise of the cost after which a solve has stalled.
cdef int MAX_NOISE = 8
# Part of the promised gain that a step must reach.
cdef double ENOUGH = 1e-4
# Part of the squares of the violations at which the cost counts again.
cdef double LOWERED = 1e-2

cdef enum Outcome:
    REJECTED = 0
    ACCEPTED
    NOISE                        # accepted, with a change within rounding


cdef bint all_finite(const double* x, Py_ssize_t n) noexcept nogil:
    cdef Py_ssize_t i
    cdef double total = 0.0
    for i in range(n):
        total += 0.0 * x[i]
    return total == 0.0


cdef double dot(const double* x, const double* y, Py_ssize_t n) noexcept nogil:
    cdef Py_ssize_t i
    cdef double total = 0.0
    for i in range(n):
        total += x[i] * y[i]
    return total


cdef class Exact(Supervised):
    """A solve with exact rows.

    Parameters
    ----------
    evaluation : Evaluation
    rows : RowTable
    solver : LinearSolver, of double precision
    config : LmConfig
    watcher : object
        As of `Minimiser`; its ``started(loop)`` is called where a start is not sound.
    watched : bool
        Whether the watcher wants to see each attempt.
    curvature_of_residuals : function without arguments, or None
        Makes the RowTable of the residuals, for their second derivatives.

    Attributes
    ----------
    multipliers, scale : (rows,) arrays
        Multipliers of f; magnitude of the terms of each row, the largest so far.
    tolerance : (rows,) array
        Violations that count as none.
    """

    cdef readonly RowTable rows
    cdef readonly double start_cost
    cdef readonly Py_ssize_t accepted
    cdef readonly double damping
    cdef readonly object multipliers, scale, tolerance
    cdef RowTable _residuals             # None: their second derivatives are not used
    cdef object _curvature_of_residuals
    cdef object _residual_memory
    cdef double* _residual_values        # [their rows + entries]
    cdef Quadratic _quadratic
    cdef Settings _settings
    cdef ComponentLanes _all             # None: all instances are evaluated
    cdef object _memory, _raw
    cdef void* _raw_gradient             # in the precision of the problem
    cdef void* _raw_values
    cdef Py_ssize_t _m, _n, _v
    cdef double _row_tolerance           # relative to the scale of a row
    cdef double _optimal                 # of the first-order conditions, relative to residuals
    cdef double _noise                   # rounding of the cost, relative
    cdef double _floor                   # of a force, relative to the terms that it is made of
    # At the accepted state.
    cdef double _cost                    # f
    cdef double* _gradient               # [n]
    cdef double* _values                 # [values] of J'J
    cdef double* _metric                 # [n] positive diagonal by which steps are measured
    cdef double* _root                   # [n] its roots
    cdef double* _sizes                  # [n] of the scalars
    cdef double* _c                      # [rows]
    cdef double* _entries                # [entries]
    cdef double* _weights                # [rows]
    cdef double* _violations             # [rows]
    # Of a step.
    cdef bint _has_hessian
    cdef double* _hessian                # [values] J'J, or with second derivatives
    cdef double* _damped                 # [n] its diagonal and damping
    cdef double* _aim                    # [rows] with the violations that a step is to remove
    cdef double* _y                      # [rows] its multipliers
    cdef double* _step                   # [n]
    cdef double* _work                   # [n]
    cdef double* _linear                 # [rows]
    cdef double* _penalties              # [rows]
    # At the state that is tried.
    cdef double _trial_cost              # f
    cdef double* _trial_c
    cdef double* _trial_violations
    cdef double* _trial_entries
    # Results.
    cdef double* _multipliers
    cdef double* _scale
    cdef double* _tolerance
    # Of the loop.
    cdef double _reach                   # part of the violations that a step is to remove
    cdef double _optimality              # 1: the first-order conditions just hold
    cdef double _last_optimality
    cdef bint _curved                    # whether the next step takes second derivatives
    cdef bint _second_order              # those of the residuals too
    cdef int _retry, _quiet

    def __init__(
        self, Evaluation evaluation, RowTable rows, LinearSolver solver, config, watcher,
        bint watched, curvature_of_residuals=None
    ):
        cdef Py_ssize_t m = rows.count, n = rows.size, v = rows.value_count, e = rows.entries
        cdef double* place
        self.evaluation, self.rows, self.solver = evaluation, rows, solver
        self._m, self._n, self._v = m, n, v
        self._settings = settings_of(config, evaluation.dtype, evaluation.guarded, watched, n)
        self._curvature_of_residuals = curvature_of_residuals
        self._quadratic = Quadratic(rows, solver)
        self.watch(watcher, 64)
        if evaluation.single:
            self._row_tolerance, self._optimal, self._noise = 2e-5, 2e-3, 1e-6
            self._floor = 1e-5
        else:
            self._row_tolerance, self._optimal, self._noise = 1e-9, 1e-8, 1e-15
            self._floor = 1e-13
        self._raw = evaluation.workspace()
        dtype = evaluation.dtype
        self._raw_gradient = writable(self._raw[0], dtype)
        self._raw_values = writable(self._raw[1], dtype)
        self._memory = np.zeros(9 * m + 7 * n + 2 * v + 2 * e + 1)
        self.multipliers, self.scale = np.zeros(m), np.zeros(m)
        self.tolerance = np.zeros(m)
        self._multipliers = <double*>writable(self.multipliers, np.float64)
        self._scale = <double*>writable(self.scale, np.float64)
        self._tolerance = <double*>writable(self.tolerance, np.float64)
        place = <double*>writable(self._memory, np.float64)
        self._c, self._weights, self._violations = place, place + m, place + 2 * m
        self._aim, self._y, self._linear = place + 3 * m, place + 4 * m, place + 5 * m
        self._penalties, self._trial_c = place + 6 * m, place + 7 * m
        self._trial_violations = place + 8 * m
        place += 9 * m
        self._gradient, self._metric, self._root = place, place + n, place + 2 * n
        self._sizes, self._damped, self._step = place + 3 * n, place + 4 * n, place + 5 * n
        self._work = place + 6 * n
        place += 7 * n
        self._values, self._hessian = place, place + v
        self._entries, self._trial_entries = place + 2 * v, place + 2 * v + e
        self.start_cost, self._reach = NAN, 1.0

    def run(self):
        """Solve; return the status. The accepted state is the best one found.

        What the watcher, a native function or the linear solver raised passes through.
        """
        with nogil:
            self._run()
        return self._ended()

    def can_hold(self, counted, scale):
        """Whether rows can hold together, as far as a search from the accepted state finds out.

        Parameters
        ----------
        counted : (rows,) float array, 0 leaves a row out
        scale : (rows,) magnitude of their terms
        """
        self.scale[:] = scale
        cdef const double* factors = <const double*>writable(counted, np.float64, self._m)
        with nogil:
            self._began = self._mark = self._last_check = seconds()
            self._status = RUNNING
            self._linearise()
            self._lower(factors, 0.0)
        return self._ended() == STATUSES[RUNNING]

    def _ended(self):
        if self._failure is not None:
            failure, self._failure = self._failure, None
            raise failure
        return "infeasible" if self._status == INFEASIBLE else STATUSES[self._status]

    @property
    def current_cost(self):
        """Sum of squared residuals at the last linearisation."""
        return 2.0 * self._cost

    @property
    def gradient(self):
        """J'r (size,) at the last linearisation."""
        return np.array(self._raw[0][: self._n], dtype=np.float64)

    @property
    def diagonal(self):
        """Diagonal of J'J and of the squares of the rows' derivatives."""
        squares = np.zeros(self._v)
        weights = np.ones(self._m)
        self.rows.add_squares(
            self._entries, <double*>writable(weights, np.float64),
            <double*>writable(squares, np.float64))
        found = np.array(self._raw[1][: self._v], dtype=np.float64) + squares
        return np.array([found[self.rows.diagonal_at[i]] for i in range(self._n)])

    # --- the loop ----------------------------------------------------------------------------

    cdef void _run(self) noexcept nogil:
        self._began = self._mark = self._last_check = seconds()
        self._status = RUNNING
        self._linearise()
        self.start_cost = 2.0 * self._cost
        if self._status == RUNNING and not self._sound():
            with gil:
                self._start()
        self._begin()
        self._last_optimality = INFINITY
        while self._status == RUNNING:
            self._iterate()

    cdef void _begin(self) noexcept nogil:
        self._retry, self._curved, self._has_hessian = 0, True, False

    cdef bint _sound(self) noexcept nogil:
        """Whether a solve can start: all is finite, everything that moves matters."""
        cdef Py_ssize_t i
        cdef bint sound = isfinite(self._cost) and all_finite(self._entries, self.rows.entries)
        for i in range(self._n):
            self._work[i] = self._settings.min_diagonal
        for i in range(self.rows.entries):
            self._work[self.rows._column[i]] += self._entries[i] * self._entries[i]
        for i in range(self._n):
            sound &= isfinite(self._gradient[i])
            sound &= self._values[self.rows.diagonal_at[i]] + self._work[i] > 0.0
        for i in range(self._m):
            sound &= isfinite(self._c[i])
            sound &= (
                self.rows._start[i] < self.rows._start[i + 1]
                or self._violations[i] <= self._tolerance[i])
        return sound

    cdef void _iterate(self) noexcept nogil:
        cdef Py_ssize_t i
        cdef int outcome
        cdef bint feasible, slow
        cdef double y
        self._end_by_limits()
        if self._status != RUNNING:
            return
        self._pose()
        for i in range(self._m):
            self._aim[i] = self._aimed(i, self._c[i])
        if not self._quadratic.solve(self._aim, self._multipliers, self._tolerance):
            if self.solver.raised.any:
                self._take_failure()
            elif self._curved and self._has_curvature():
                self._curved = self._has_hessian = False
            elif not self._raise():
                self._restore(STALLED)
            return
        feasible = self._are_feasible(NULL)
        if not self._quadratic.holds:
            if not feasible:
                self._restore(RUNNING)
            elif not self._raise():  # rows contradict each other within their tolerance
                self._status = STALLED
            return
        memcpy(self._step, self._quadratic.step, self._n * sizeof(double))
        memcpy(self._y, self._quadratic.multipliers, self._m * sizeof(double))
        self._take_optimality()
        if feasible and self._optimality <= 1.0:
            memcpy(self._multipliers, self._y, self._m * sizeof(double))
            self._polish()
            self._status = CONVERGED
            return
        for i in range(self._m):
            y = 1.5 * fabs(self._y[i])
            # Where multipliers are small, violations still count like the cost of removing them.
            self._penalties[i] = max(
                max(y, self._weights[i] / WEIGHT * self._violations[i]),
                0.5 * (self._penalties[i] + y))
        outcome = self._attempt()
        if self._status != RUNNING:
            return
        if outcome == REJECTED:
            self._retry += 1
            if self._curved and self._has_curvature() and self.damping > 1e-2:
                self._curved = self._has_hessian = False
            if not self._raise():
                self._restore(STALLED)
            return
        memcpy(self._multipliers, self._y, self._m * sizeof(double))
        slow = feasible and self._optimality > SLOW * self._last_optimality
        if (slow or self._retry > 2) and not self._second_order:
            self._take_second_order()
        self._quiet = self._quiet + 1 if outcome == NOISE else 0
        if self._quiet > MAX_NOISE:
            self._status = STALLED
        self._last_optimality = self._optimality
        self._linearise()
        self._begin()

    cdef void _end_by_limits(self) noexcept nogil:
        if self.attempts >= self._settings.max_iters:
            self._status = MAX_ITERATIONS
        elif seconds() - self._began >= self._settings.time_limit:
            self._status = TIME_LIMIT
        elif self._interrupted():
            self._status = ABORTED
        elif (
            self._settings.cost_threshold != 0.0
            and 2.0 * self._cost <= self._settings.cost_threshold and self._are_feasible(NULL)
        ):
            self._status = COST_THRESHOLD

    cdef void _linearise(self) noexcept nogil:
        """Evaluate cost, rows and derivatives at the accepted state."""
        cdef Py_ssize_t i
        cdef double largest = 0.0, typical = 0.0, diagonal, size, length, along
        self._cost = 0.5 * self.evaluation.linearise(
            self._raw_gradient, self._raw_values, self._all)
        if self.evaluation.single:
            for i in range(self._n):
                self._gradient[i] = (<const float*>self._raw_gradient)[i]
            for i in range(self._v):
                self._values[i] = (<const float*>self._raw_values)[i]
        else:
            memcpy(self._gradient, self._raw_gradient, self._n * sizeof(double))
            memcpy(self._values, self._raw_values, self._v * sizeof(double))
        self.rows.evaluate_at(self.evaluation.states.current, self._c, self._entries)
        self._take_failure()
        self.rows.sizes_of(self._sizes)
        for i in range(self._n):
            typical = max(typical, self._sizes[i])
            if not self.rows.still[i]:
                largest = max(largest, self._values[self.rows.diagonal_at[i]])
        largest = largest if largest > 0.0 else 1.0
        typical = typical if typical > 0.0 else 1.0
        # What the cost does not depend on must not move for nothing: rows may be curved along it.
        for i in range(self._n):
            diagonal = self._values[self.rows.diagonal_at[i]]
            self._metric[i] = 1.0 if self.rows.still[i] else max(
                diagonal, (1e-8 if diagonal > 0.0 else 1e-2) * largest)
            self._root[i] = sqrt(self._metric[i])
            self._work[i] = max(self._sizes[i], 1e-6 * typical)
        self.rows.lengths_of(self._entries, self._work, self._linear)
        self.rows.lengths_of(self._entries, NULL, self._weights)
        self.rows.lengths_of(self._entries, self._root, self._aim)
        for i in range(self._m):
            self._scale[i] = max(self._scale[i], self._linear[i])
            self._tolerance[i] = self._row_tolerance * max(self._scale[i], 1e-300)
            length, along = self._weights[i], self._aim[i]
            self._weights[i] = (
                WEIGHT * (along / length) * (along / length) / length / length
                if length > 0.0 else 1.0)
        self.rows.violations_of(self._c, self._violations)

    cdef double _aimed(self, Py_ssize_t i, double c) noexcept nogil:
        """A row, with the violation that a step is to remove."""
        return self._reach * c if self.rows._equal[i] or c < 0.0 else c

    cdef bint _are_feasible(self, const double* counted) noexcept nogil:
        """Whether rows hold, of all or of those that are counted."""
        cdef Py_ssize_t i
        for i in range(self._m):
            if not self._violations[i] <= self._tolerance[i] and (
                counted == NULL or counted[i] > 0.0
            ):
                return False
        return True

    cdef bint _has_curvature(self) noexcept nogil:
        cdef Py_ssize_t i
        if self._second_order:
            return True
        if self.rows.is_curved:
            for i in range(self._m):
                if self._multipliers[i] != 0.0:
                    return True
        return False

    cdef void _pose(self) noexcept nogil:
        """Take the Hessian of the Lagrangian, or Gauss-Newton's part of it, and damp it."""
        cdef Py_ssize_t i
        cdef double damping = max(self.damping, 1e-12)
        if not self._has_hessian:
            self._has_hessian = True
            memcpy(self._hessian, self._values, self._v * sizeof(double))
            if self._curved and self._has_curvature():
                for i in range(self._m):
                    self._linear[i] = -self._multipliers[i]
                self.rows.add_curvature(
                    self._linear, self._entries, self._sizes, self._hessian)
                if self._second_order:
                    self._add_residuals()
        for i in range(self._n):
            self._damped[i] = (
                self._hessian[self.rows.diagonal_at[i]] + damping * self._metric[i])
        self._quadratic.pose(
            self._entries, self._hessian, self._damped, self._gradient, self._weights)

    cdef void _add_residuals(self) noexcept nogil:
        """Add the second derivatives of the residuals."""
        cdef double* entries = self._residual_values + self._residuals.count
        self._residuals.evaluate_at(
            self.evaluation.states.current, self._residual_values, entries)
        self._residuals.add_curvature(
            self._residual_values, entries, self._sizes, self._hessian)

    cdef void _take_second_order(self) noexcept nogil:
        if self._curvature_of_residuals is None:
            return
        with gil:
            self._make_residuals()

    def _make_residuals(self):
        try:
            self._residuals = self._curvature_of_residuals()
            self._curvature_of_residuals = None
            self._residual_memory = np.empty(self._residuals.count + self._residuals.entries + 1)
            self._residual_values = <double*>writable(self._residual_memory, np.float64)
            self._second_order = 0 < self._residuals.colours <= MAX_COLOURS
        except BaseException as error:
            self._failure, self._status = error, ABORTED

    cdef void _take_optimality(self) noexcept nogil:
        """The first-order conditions, relative to their tolerance."""
        cdef Py_ssize_t i, e
        cdef double scale = sqrt(2.0 * self._cost), terms = 0.0, left = 0.0, tolerance
        cdef double slack = 0.0, weight = 2.0 * self._cost
        memset(self._work, 0, self._n * sizeof(double))
        for i in range(self._m):
            for e in range(self.rows._start[i], self.rows._start[i + 1]):
                self._work[self.rows._column[e]] += fabs(self._entries[e] * self._y[i])
            weight += fabs(self._y[i]) * self._scale[i]
            if not self.rows._equal[i]:
                slack += self._y[i] * max(self._c[i], 0.0)
        for i in range(self._n):
            scale = max(scale, self._work[i] / self._root[i])
            terms += self._metric[i] * self._sizes[i] * self._sizes[i]
            self._work[i] = -self._gradient[i]
        self.rows.add_transposed(self._entries, self._y, self._work)
        for i in range(self._n):
            left = max(left, fabs(self._work[i]) / self._root[i])
        tolerance = max(max(self._optimal * scale, self._floor * sqrt(terms)), 1e-300)
        self._optimality = max(left / tolerance, slack / max(self._optimal * weight, 1e-300))

    # --- attempts ----------------------------------------------------------------------------

    cdef double _merit(self, double cost, const double* violations) noexcept nogil:
        return cost + dot(self._penalties, violations, self._m)

    cdef int _attempt(self) noexcept nogil:
        """Try the step, if necessary corrected."""
        cdef Py_ssize_t i
        cdef double before = self._merit(self._cost, self._violations), promise
        cdef double noise = self._noise * (
            self._cost + dot(self._penalties, self._scale, self._m))
        cdef double cost = NAN
        # Without damping: what the model promises.
        for i in range(self._n):
            self._damped[i] = self._hessian[self.rows.diagonal_at[i]]
        self.rows.symmetric_product(self._hessian, self._damped, self._step, self._work)
        promise = -dot(self._gradient, self._step, self._n)
        promise -= 0.5 * dot(self._step, self._work, self._n)
        self.rows.product(self._entries, self._step, self._linear)
        for i in range(self._m):
            self._trial_c[i] = self._c[i] + self._linear[i]
        self.rows.violations_of(self._trial_c, self._trial_violations)
        for i in range(self._m):
            promise += self._penalties[i] * (self._violations[i] - self._trial_violations[i])
        if self._moved(self._step):
            cost = 2.0 * self._trial_cost
            if self._is_enough(before, promise, noise):
                return self._accept(before, promise, noise)
            if promise > noise and self._correct() and self._moved(self._step):
                if self._is_enough(before, promise, noise):
                    return self._accept(before, promise, noise)
        self._record_attempt(promise, cost, False)
        return REJECTED

    cdef bint _is_enough(self, double before, double promise, double noise) noexcept nogil:
        cdef double after = self._merit(self._trial_cost, self._trial_violations)
        if promise <= 10.0 * noise:
            return fabs(promise) <= 10.0 * noise and after <= before + 100.0 * noise
        return before - after >= ENOUGH * promise - noise

    cdef int _accept(self, double before, double promise, double noise) noexcept nogil:
        cdef double gain = before - self._merit(self._trial_cost, self._trial_violations)
        self.evaluation.states.accept()
        self.accepted += 1
        if gain > 0.25 * promise:
            self._reach = min(1.0, 4.0 * self._reach)
            self.damping *= 0.1 if gain > 0.75 * promise else 0.4
            if self.damping < LEAST_DAMPING:
                self.damping = 0.0
        self._record_attempt(promise, 2.0 * self._trial_cost, True)
        return NOISE if promise <= 10.0 * noise else ACCEPTED

    cdef bint _moved(self, const double* step) noexcept nogil:
        """Try a step; False if cost or rows are not finite there."""
        cdef int other = 1 - self.evaluation.states.current
        self.rows.move(step)
        self._trial_cost = 0.5 * self.evaluation.cost(other)
        self.rows.evaluate_at(other, self._trial_c, self._trial_entries)
        self._take_failure()
        self.rows.violations_of(self._trial_c, self._trial_violations)
        return isfinite(self._trial_cost) and all_finite(self._trial_c, self._m)

    cdef bint _correct(self) noexcept nogil:
        """Take the step with the rows as they turned out, a second-order correction."""
        cdef Py_ssize_t i
        for i in range(self._n):
            self._damped[i] += max(self.damping, 1e-12) * self._metric[i]
        for i in range(self._m):
            self._aim[i] = self._aimed(i, self._trial_c[i]) - self._linear[i]
        if not self._quadratic.solve(self._aim, self._y, self._tolerance):
            return False
        if not self._quadratic.holds:
            return False
        memcpy(self._step, self._quadratic.step, self._n * sizeof(double))
        return True

    cdef void _polish(self) noexcept nogil:
        """Take the last step too, if it raises neither violations nor cost."""
        cdef Py_ssize_t i
        cdef double most = self._cost * (1.0 + self._noise)
        if not self._moved(self._step):
            return
        for i in range(self._m):
            most += fabs(self._y[i]) * self._violations[i]
            if self._trial_violations[i] > max(self._violations[i], 0.1 * self._tolerance[i]):
                return
        if self._trial_cost <= most:
            self.evaluation.states.accept()

    cdef bint _raise(self) noexcept nogil:
        """More damping; False if there is no more."""
        self._reach *= 0.3
        self.damping = max(FIRST_DAMPING, 10.0 * self.damping)
        return self.damping <= MAX_DAMPING

    cdef void _record_attempt(self, double promise, double cost, bint accepted) noexcept nogil:
        cdef Py_ssize_t i
        cdef double largest = 0.0, now = seconds()
        for i in range(self._n):
            largest = max(largest, fabs(self._gradient[i]))
        self._now.iteration = self.accepted + (not accepted)
        self._now.retry, self._now.accepted = self._retry, accepted
        self._now.factored, self._now.pivot = True, -1
        self._now.cost, self._now.trial_cost = 2.0 * self._cost, cost
        self._now.predicted = self._now.promise = 2.0 * promise
        self._now.radius = NAN
        self._now.damping = self._now.next_damping = self.damping
        self._now.step_norm = sqrt(dot(self._step, self._step, self._n))
        self._now.gradient = 2.0 * largest
        self._now.seconds = now - self._mark
        self._mark = now
        self._keep_record()
        if self._settings.watched and self._status == RUNNING:
            with gil:
                self._show()

    # --- violations alone --------------------------------------------------------------------

    cdef void _restore(self, int status) noexcept nogil:
        """Lower the violations until all rows hold, or most are gone; then the status is that."""
        cdef Py_ssize_t i
        self.damping, self._reach = 0.0, 1.0
        self._lower(NULL, LOWERED)
        memset(self._multipliers, 0, self._m * sizeof(double))
        memset(self._penalties, 0, self._m * sizeof(double))
        if self._status == RUNNING:
            self._status = status
        self._begin()

    cdef void _lower(self, const double* counted, double enough) noexcept nogil:
        """Make the squares of the violations least, by Levenberg's method.

        Still running where the rows hold, or enough was gained.

        Parameters
        ----------
        counted : (rows,) factors of their weights, 0 leaves a row out; NULL: all count
        enough : part of the weighted squares at which to stop
        """
        cdef Py_ssize_t i
        cdef double damping = 1e-6, total, first = NAN, promise, after, gain
        cdef bint curved = True, accepted
        while True:
            if self._are_feasible(counted):
                return
            self._end_by_limits()
            if self._status != RUNNING:
                return
            total = 0.0
            for i in range(self._m):
                # Of the rows in use now; their weights stay until the next linearisation.
                self._penalties[i] = (
                    self._weights[i] / WEIGHT * (1.0 if counted == NULL else counted[i]))
                total += 0.5 * self._penalties[i] * self._violations[i] * self._violations[i]
            if first != first:
                first = total
            if total <= enough * first:
                return
            memset(self._hessian, 0, self._v * sizeof(double))
            if curved and self.rows.is_curved:
                # Where rows stay violated, their curvature decides how far a step may go.
                for i in range(self._m):
                    self._linear[i] = self._penalties[i] * (
                        self._c[i] if self.rows._equal[i] else min(self._c[i], 0.0))
                self.rows.add_curvature(
                    self._linear, self._entries, self._sizes, self._hessian)
            for i in range(self._n):
                self._damped[i] = (
                    self._hessian[self.rows.diagonal_at[i]] + damping * self._metric[i])
            memset(self._work, 0, self._n * sizeof(double))
            self._quadratic.pose(
                self._entries, self._hessian, self._damped, self._work, self._penalties)
            if not self._quadratic.minimum(self._c):
                self._take_failure()
                damping, curved = damping if curved else 10.0 * damping, False
                if damping > MAX_DAMPING:
                    self._status = INFEASIBLE
                continue
            memcpy(self._step, self._quadratic.step, self._n * sizeof(double))
            self.rows.violations_of(self._quadratic.linear, self._trial_violations)
            promise = total
            for i in range(self._m):
                promise -= (
                    0.5 * self._penalties[i]
                    * self._trial_violations[i] * self._trial_violations[i])
            if promise <= 1e-12 * total or damping > MAX_DAMPING:
                self._status = INFEASIBLE
                return
            after = INFINITY
            if self._moved(self._step):
                after = 0.0
                for i in range(self._m):
                    after += (
                        0.5 * self._penalties[i]
                        * self._trial_violations[i] * self._trial_violations[i])
            gain = total - after
            accepted = gain >= ENOUGH * promise
            if accepted:
                self.evaluation.states.accept()
                self.accepted += 1
            self._retry = 0
            self._record_attempt(
                promise, NAN if after == INFINITY else 2.0 * self._trial_cost, accepted)
            if self._status != RUNNING:
                return
            if accepted:
                damping = max(LEAST_DAMPING, 0.1 * damping if gain > 0.5 * promise else damping)
                curved = True
                self._linearise()
            else:
                damping *= 10.0
