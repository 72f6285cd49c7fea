# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
"""Levenberg-Marquardt with multiplicative damping of the diagonal.

Each iteration solves ``(J'J + lambda diag(J'J)) step = -J'r`` (Marquardt, SIAM J. Appl. Math. 11,
1963). A step that lowers the cost is accepted and lambda shrinks; any other is retried with the
same linearisation and a larger lambda. The drivers of lambda: a fixed ladder, or the gain ratio
of Nielsen (IMM-REP-1999-05, "Damping parameter in Marquardt's method").
"""

import numpy as np

from cpython.exc cimport PyErr_CheckSignals
from libc.math cimport INFINITY, NAN, isfinite, sqrt

from arael.runtime.address cimport address, writable
from arael.runtime.box cimport Box
from arael.runtime.clock cimport seconds
from arael.runtime.evaluation cimport Evaluation
from arael.runtime.linear.base cimport LinearSolver
from arael.runtime.vectors cimport Sums, Vectors

from arael.runtime.records import check_record, probe_of

STATUSES = (
    "running",
    "converged",
    "cost_threshold",
    "max_iterations",
    "gradient_tolerance",
    "parameter_tolerance",
    "predicted_reduction",
    "time_limit",
    "driver_terminated",
    "observer_terminated",
    "lambda_ceiling",
    "retry_budget",
    "aborted",
)

RECORD = np.dtype(
    [
        ("iteration", np.int32),
        ("retry", np.int32),
        ("accepted", np.int32),
        ("factored", np.int32),
        ("pivot", np.int64),
        ("cost", np.float64),
        ("trial_cost", np.float64),
        ("predicted", np.float64),
        ("damping", np.float64),
        ("next_damping", np.float64),
        ("step_norm", np.float64),
        ("gradient", np.float64),
        ("seconds", np.float64),
    ]
)

probe = probe_of(RECORD)
check_record("Record", RECORD, (<const Record*>address(probe, RECORD))[0], sizeof(Record))

# Seconds between looks at pending signals (Ctrl-C): each takes the GIL.
cdef double SIGNAL_INTERVAL = 0.02
# A driver that rejected so often in a row that its growth overflows has given up.
cdef double GROWTH_LIMIT = 1e9


cdef class Minimiser:
    """One solve.

    Parameters
    ----------
    evaluation : Evaluation
        The problem; its accepted state moves.
    solver : LinearSolver
    box : Box
    config : LmConfig
    watcher : object
        ``started(minimiser)`` is called after the first linearisation and may raise;
        ``stepped(minimiser, record)`` after each attempt if `watched`, and ends the solve by False.
    watched : bool
    """

    def __init__(self, Evaluation evaluation, LinearSolver solver, Box box, config, watcher,
                 bint watched):
        if bool(solver.single) != bool(evaluation.single):
            raise ValueError("the linear solver and the problem differ in precision")
        self.evaluation, self.solver, self._box = evaluation, solver, box
        self._watcher = watcher
        self._epsilon = float(np.finfo(evaluation.dtype).eps)
        self._read(config, watched)
        self.vectors = Vectors(evaluation.size, evaluation.totals, evaluation.threads)
        self._grow_history(min(self._settings.max_iters, 1024) + 1)

    def _read(self, config, bint watched):
        s = &self._settings
        s.abs_precision, s.rel_precision = config.abs_precision, config.rel_precision
        s.max_iters, s.min_iters, s.patience = config.max_iters, config.min_iters, config.patience
        s.initial_lambda = config.initial_lambda
        s.lambda_floor = config.floor(self.evaluation.single)
        s.lambda_ceiling, s.retry_budget = config.lambda_ceiling, config.retry_budget
        s.cost_threshold = config.cost_threshold
        s.gradient_tolerance = config.gradient_tolerance
        s.parameter_tolerance = config.parameter_tolerance
        s.predicted_reduction_tolerance = config.predicted_reduction_tolerance
        s.min_diagonal = config.min_diagonal
        s.time_limit = INFINITY if config.time_limit is None else config.time_limit
        s.watched = watched
        self._driver = config.damping if callable(config.damping) else None
        s.damping = CUSTOM if self._driver is not None else (
            NIELSEN if config.damping == "nielsen" else LADDER
        )
        self.damping = max(s.initial_lambda, s.lambda_floor)
        self._growth = 2

    def _grow_history(self, Py_ssize_t capacity):
        history = np.zeros(capacity, dtype=RECORD)
        if self._history is not None:
            history[: len(self._history)] = self._history
        # Whatever may raise comes before the first change: the old records must stay reachable.
        cdef void* records = writable(history, RECORD, capacity)
        self._history = history
        self._capacity = capacity
        self._records = <Record*>records

    # --- from Python -------------------------------------------------------------------------

    def run(self):
        """Solve; return the status.

        What watcher, driver, interpreter or linear solver raised passes through.
        """
        with nogil:
            self._run()
        if self._failure is not None:
            failure, self._failure = self._failure, None
            raise failure
        return STATUSES[self._status]

    @property
    def history(self):
        """Attempts so far, as a structured array of `RECORD`."""
        return self._history[: self.attempts].copy()

    @property
    def timing(self):
        """Seconds per phase."""
        return {
            "first_factor": self._phases[FIRST_FACTOR],
            "linearise": self._phases[LINEARISE],
            "factor": self._phases[FACTOR],
            "solve": self._phases[SOLVE],
            "refresh": self._phases[REFRESH],
            "cost": self._phases[COST],
        }

    # --- the loop ----------------------------------------------------------------------------

    cdef void _run(self) noexcept nogil:
        self._began = self._mark = self._last_check = seconds()
        self.evaluation.guard()
        self.start_cost = self.current_cost = self.evaluation.cost(self.evaluation.states.current)
        self._lap(COST)
        self._now.iteration = 0
        self._status = RUNNING
        while self._status == RUNNING:
            self._linearise()
            while self._status == RUNNING:
                self._attempt()
                if self._now.accepted:
                    break

    cdef void _linearise(self) noexcept nogil:
        """Gradient, blocks and diagonal at the accepted state."""
        cdef Settings* s = &self._settings
        cdef double cost
        self._mark = seconds()
        cost = self.evaluation.linearise(self.vectors.gradient, self.vectors.values)
        if self.evaluation.guarded:
            self.current_cost = cost  # other instances may act than those the step was judged by
        if self._box.count:
            self._box.hold(self.vectors.gradient, self.vectors.values)
        self._now.gradient = 2 * self.vectors.take_diagonal(s.min_diagonal)
        self._now.iteration += 1
        self._now.retry = 0
        self._lap(LINEARISE)
        if self._now.iteration == 1:
            with gil:
                self._start()
        self._take_failure()
        if self._status != RUNNING:
            return
        if s.cost_threshold > 0 and self.current_cost <= s.cost_threshold:
            self._status = COST_THRESHOLD
        elif s.gradient_tolerance > 0 and self._now.gradient <= s.gradient_tolerance:
            self._status = GRADIENT_TOLERANCE

    cdef void _attempt(self) noexcept nogil:
        """Damp, factorise, solve, evaluate; accept or reject."""
        cdef double began = seconds()
        self._now.accepted = False
        if self.attempts >= self._settings.max_iters:
            self._status = MAX_ITERATIONS
        elif began - self._began >= self._settings.time_limit:
            self._status = TIME_LIMIT
        elif self._interrupted():
            self._status = ABORTED
        if self._status != RUNNING:
            return
        self._now.cost, self._now.damping = self.current_cost, self.damping
        self._now.trial_cost = self._now.predicted = self._now.step_norm = NAN
        if self._factor():
            self._propose()
            self._now.accepted = self._now.trial_cost < self.current_cost
        if self.evaluation.raised.any or self.solver.raised.any:
            self._now.accepted = False
        self._next_damping()
        self._now.seconds = seconds() - began
        self._judge()

    cdef bint _factor(self) noexcept nogil:
        cdef Py_ssize_t failed
        self._mark = seconds()
        self.vectors.prepare(self.damping)
        failed = self.solver.factor_with(
            self.vectors.values, self.vectors.damped, self.vectors.step)
        self._now.pivot, self._now.factored = failed - 1, failed == 0
        self._lap(FACTOR if self.attempts else FIRST_FACTOR)
        return failed == 0

    cdef void _propose(self) noexcept nogil:
        """The step, what it promises, and what it brings."""
        cdef Sums sums
        cdef bint cut
        self._mark = seconds()
        self.solver.finish(self.vectors.step)
        cut = self._box.count > 0 and self._box.clamp(self.vectors.step)
        sums = self.vectors.products()
        self._now.step_norm = sqrt(sums.length)
        # Of the exact solution, step' H step = -slope - added.
        if cut:
            self._now.predicted = -2 * sums.slope - self._box.curvature(
                self.vectors.values, self.vectors.step)
        else:
            self._now.predicted = -sums.slope + sums.added
        self._lap(SOLVE)
        self.evaluation.states.move(self.vectors.step, self.vectors.threads)
        self._lap(REFRESH)
        self._now.trial_cost = self.evaluation.cost(1 - self.evaluation.states.current)
        self._lap(COST)

    # --- damping -----------------------------------------------------------------------------

    cdef void _next_damping(self) noexcept nogil:
        cdef double floor = self._settings.lambda_floor
        if self._settings.damping == CUSTOM:
            with gil:
                self._drive()
        elif self._settings.damping == NIELSEN:
            self._nielsen()
        elif self._now.accepted:
            self.damping *= 0.2
        else:
            self.damping *= 10
        if self.damping < floor:
            self.damping = floor
        self._now.next_damping = self.damping

    cdef void _nielsen(self) noexcept nogil:
        cdef double gain, shape
        if not self._now.accepted:
            self.damping *= self._growth
            self._growth *= 2
            if self._growth > GROWTH_LIMIT:
                self._status = DRIVER_TERMINATED
            return
        gain = (self._now.cost - self._now.trial_cost) / self._now.predicted
        shape = 2 * gain - 1
        self.damping *= max(1.0 / 3.0, 1 - shape * shape * shape) if isfinite(gain) else 1.0 / 3.0
        self._growth = 2

    def _drive(self):
        try:
            found = self._driver(self._record())
            if found is None:
                self._status = DRIVER_TERMINATED
            else:
                self.damping = float(found)
                if not isfinite(self.damping) or self.damping < 0:
                    raise ValueError(f"the damping driver returned {found!r} for lambda")
        except KeyboardInterrupt:
            self._status = ABORTED
        except BaseException as error:
            self._failure, self._status = error, ABORTED

    # --- termination -------------------------------------------------------------------------

    cdef void _judge(self) noexcept nogil:
        """Take an accepted step over, keep the record, and decide whether to go on."""
        cdef int verdict
        self._keep_record()
        if self._now.accepted:
            self.evaluation.states.accept()
            self.current_cost = self._now.trial_cost
            self.accepted += 1
        verdict = self._verdict()
        self._take_failure()
        if self._settings.watched and self._failure is None:
            with gil:
                self._show()
        self._now.retry += not self._now.accepted
        if verdict != RUNNING and self._status != ABORTED:
            self._status = verdict

    cdef int _verdict(self) noexcept nogil:
        cdef Settings* s = &self._settings
        cdef double before = self._now.cost
        cdef int found
        if self._now.accepted:
            found = self._after_acceptance()
            if found != RUNNING:
                return found
        elif self._now.factored and self._at_noise_floor():
            return CONVERGED
        if self._now.factored:
            if s.parameter_tolerance > 0 and self._now.step_norm <= s.parameter_tolerance * (
                self.evaluation.states.norm() + s.parameter_tolerance
            ):
                return PARAMETER_TOLERANCE
            if (s.predicted_reduction_tolerance > 0
                    and self._now.predicted <= s.predicted_reduction_tolerance * before):
                return PREDICTED_REDUCTION
        if not self._now.accepted:
            if self.damping > s.lambda_ceiling:
                return LAMBDA_CEILING
            if s.retry_budget > 0 and self._now.retry >= s.retry_budget:
                return RETRY_BUDGET
        return RUNNING

    cdef int _after_acceptance(self) noexcept nogil:
        cdef Settings* s = &self._settings
        cdef double before = self._now.cost, drop = self._now.cost - self._now.trial_cost
        if s.cost_threshold > 0 and self.current_cost <= s.cost_threshold:
            return COST_THRESHOLD
        if drop < 16 * self._epsilon * before:
            return CONVERGED
        if drop < s.abs_precision or drop < s.rel_precision * before:
            self._small_steps += 1
        else:
            self._small_steps = 0
        if self.accepted >= s.min_iters and self._small_steps > s.patience:
            return CONVERGED
        return RUNNING

    cdef bint _at_noise_floor(self) noexcept nogil:
        """Whether a rejected step failed by rounding only: nothing was promised and nothing lost.

        The gradient must be small in a measure that damping does not touch, or a solve that is
        stuck with a huge lambda would pass for converged.
        """
        cdef double noise = 1024 * self._epsilon * self._now.cost
        cdef double left = self.vectors.scaled_gradient()
        return (
            self._now.trial_cost - self._now.cost <= noise
            and self._now.predicted <= noise
            and left <= sqrt(self._epsilon) * self._now.cost
        )

    # --- where Python comes in ---------------------------------------------------------------

    cdef bint _interrupted(self) noexcept nogil:
        cdef double now = seconds()
        if now - self._last_check < SIGNAL_INTERVAL:
            return False
        self._last_check = now
        with gil:
            return self._signalled()

    def _signalled(self):
        try:
            PyErr_CheckSignals()
        except KeyboardInterrupt:
            return True
        except BaseException as error:
            self._failure = error
            return True
        return False

    def _start(self):
        try:
            self._watcher.started(self)
        except KeyboardInterrupt:
            self._status = ABORTED
        except BaseException as error:
            self._failure, self._status = error, ABORTED

    cdef void _take_failure(self) noexcept nogil:
        if self.evaluation.raised.any or self.solver.raised.any:
            with gil:
                self._raise_later()

    def _raise_later(self):
        try:
            self.solver.raised.again()
            self.evaluation.raise_failure()
        except KeyboardInterrupt:
            self._status = ABORTED
        except BaseException as error:
            self._failure, self._status = error, ABORTED

    cdef _show(self):
        try:
            if not self._watcher.stepped(self, self._record()):
                self._status = OBSERVER_TERMINATED
        except KeyboardInterrupt:
            self._status = ABORTED
        except BaseException as error:
            self._failure, self._status = error, ABORTED

    def _record(self):
        """The present attempt as one structured scalar."""
        record = np.zeros((), dtype=RECORD)
        (<Record*>writable(record, RECORD))[0] = self._now
        return record[()]

    cdef void _keep_record(self) noexcept nogil:
        if self.attempts >= self._capacity:
            with gil:
                self._make_room()
            if self.attempts >= self._capacity:
                return
        self._records[self.attempts] = self._now
        self.attempts += 1

    def _make_room(self):
        # Python may find a signal here before the loop does.
        try:
            self._grow_history(2 * self._capacity)
        except KeyboardInterrupt:
            self._status = ABORTED
        except BaseException as error:
            self._failure, self._status = error, ABORTED

    cdef void _lap(self, int phase) noexcept nogil:
        cdef double now = seconds()
        self._phases[phase] += now - self._mark
        self._mark = now
