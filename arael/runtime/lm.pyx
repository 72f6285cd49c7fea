# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
"""The loop of a solve: linearise, propose a step, accept or reject it, decide whether to go on.

The default strategy is a trust region with Powell's dogleg (dogleg.pyx). The other is
Levenberg-Marquardt: ``(J'J + lambda D) step = -J'r`` (Marquardt, SIAM J. Appl. Math. 11, 1963),
where a step that lowers the cost is accepted and lambda shrinks, and any other is retried with the
same linearisation and a larger lambda. D is the diagonal of J'J with the fixed ladder of factors
and with Nielsen's gain ratio (IMM-REP-1999-05, "Damping parameter in Marquardt's method"), or the
largest diagonal so far (Moré, 1978) with `gain`.
"""

import numpy as np

from cpython.exc cimport PyErr_CheckSignals
from libc.math cimport INFINITY, NAN, fabs, isfinite, sqrt

from arael.runtime.address cimport address, writable
from arael.runtime.box cimport Box
from arael.runtime.clock cimport seconds
from arael.runtime.dogleg cimport Dogleg
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
    "stalled",
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
        ("promise", np.float64),
        ("radius", np.float64),
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
# Undamped steps prove an end: regularisation up to here.
cdef double PROOF = 1e-6
# Square of the rounding of doubles: a cost this small a fraction of the first has no digit left.
cdef double EXACT = 4.9e-32
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
        self.dogleg = Dogleg(self.vectors, box, config.floor(evaluation.single))
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
        s.dogleg = config.chosen_strategy() == "dogleg"
        s.damping = CUSTOM if self._driver is not None else {
            "ladder": LADDER, "nielsen": NIELSEN, "gain": GAIN
        }[config.damping]
        s.by_promise = config.ending == "promise"
        self.damping = s.lambda_floor if s.dogleg else max(s.initial_lambda, s.lambda_floor)
        self.predicted_decrease = self.gradient_norm = self.noise_floor = NAN
        self._jitter[:] = [0, 0, 0]
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
        # What a result reports of its last linearisation; not computed on the way.
        self.gradient_norm = sqrt(self.vectors.scaled_gradient())
        if not (self._settings.by_promise or self._settings.dogleg):
            self._floor_of_noise()

    cdef void _linearise(self) noexcept nogil:
        """Gradient, blocks and diagonal at the accepted state."""
        cdef Settings* s = &self._settings
        cdef double cost
        self._mark = seconds()
        cost = self.evaluation.linearise(self.vectors.gradient, self.vectors.values)
        if self.evaluation.guarded and not s.by_promise:
            self.current_cost = cost  # other instances may act than those the step was judged by
        if s.by_promise or s.dogleg:
            self._floor_of_noise()
        if self._box.count:
            self._box.hold(self.vectors.gradient, self.vectors.values)
        self._now.gradient = 2 * self.vectors.take_diagonal(s.min_diagonal)
        self.dogleg.begin()
        self._proven = False
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
        elif s.by_promise and self._is_exact():
            self.predicted_decrease = self.current_cost
            self._status = CONVERGED

    cdef bint _is_exact(self) noexcept nogil:
        """Whether every residual is at the level of rounding, and steps do not help any more."""
        if self.current_cost <= EXACT * self.start_cost:
            return True
        if self.current_cost > 4 * self._epsilon * self._epsilon * self._energy:
            return False
        return self.accepted == 0 or self.current_cost > 0.25 * self._now.cost

    cdef void _floor_of_noise(self) noexcept nogil:
        """Noise of the cost: rounding of its sum, and of residuals by that of their terms.

        A residual is about as uncertain as the machine precision times its terms ``J_i x_i``; a
        change dr changes the cost by ``2 r dr + dr^2``.
        """
        cdef double terms
        self._energy = self.evaluation.states.energy(
            self.vectors.values, self.evaluation.totals.diagonal_at)
        terms = self._epsilon * self._epsilon * self._energy
        self.noise_floor = (
            4 * self._epsilon * self.current_cost + 2 * sqrt(self.current_cost * terms) + terms)

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
        self._now.cost = self.current_cost
        self._now.trial_cost = self._now.predicted = self._now.step_norm = NAN
        self._now.promise = self._now.radius = NAN
        if self._settings.dogleg:
            self._now.damping = self.dogleg.regularisation
            if self.dogleg.known or self._factor():
                self._try_dogleg()
        else:
            self._now.damping = self.damping
            if self._factor():
                self._try_damped()
        if self.evaluation.raised.any or self.solver.raised.any:
            self._now.accepted = False
        self._next_damping()
        self._now.seconds = seconds() - began
        self._judge()

    cdef bint _factor(self) noexcept nogil:
        cdef Py_ssize_t failed
        self._mark = seconds()
        if self._settings.dogleg:
            self.dogleg.prepare()
        else:
            self.vectors.prepare(self.damping, self._settings.damping == GAIN)
        self.factorisations += 1
        failed = self.solver.factor_with(
            self.vectors.values, self.vectors.damped, self.vectors.step)
        self._now.pivot, self._now.factored = failed - 1, failed == 0
        self._lap(FACTOR if self.attempts else FIRST_FACTOR)
        if failed == 0:
            self.solver.finish(self.vectors.step)
            self._lap(SOLVE)
        return failed == 0

    cdef void _try_dogleg(self) noexcept nogil:
        """A step inside the trust region, and what it brings."""
        self._mark = seconds()
        if not self.dogleg.known:
            self.dogleg.take_newton(sqrt(self._energy))
        self._now.radius = self.dogleg.radius
        self._now.predicted = self.dogleg.propose()
        self._now.promise, self._added = self.dogleg.promise, self.dogleg.added
        self._now.step_norm = sqrt(self.vectors.products().length)
        self._lap(SOLVE)
        self._look_ahead()

    cdef void _try_damped(self) noexcept nogil:
        """The damped step, what it promises, and what it brings."""
        cdef Sums sums
        cdef bint cut
        self._mark = seconds()
        sums = self.vectors.products()
        self._now.promise, self._added = -sums.slope, sums.added
        cut = self._box.count > 0 and self._box.clamp(self.vectors.step)
        if cut:
            sums = self.vectors.products()
        self._now.step_norm = sqrt(sums.length)
        # Of the exact solution, step' H step = -slope - added.
        if cut:
            self._now.predicted = -2 * sums.slope - self._box.curvature(
                self.vectors.values, self.vectors.step)
        else:
            self._now.predicted = -sums.slope + sums.added
        self._lap(SOLVE)
        self._look_ahead()

    cdef void _look_ahead(self) noexcept nogil:
        """Cost of the trial state; whether the step is accepted."""
        self._mark = seconds()
        self.evaluation.states.move(self.vectors.step, self.vectors.threads)
        self._lap(REFRESH)
        if self.evaluation.guarded and self._settings.by_promise:
            # Guards over parameters are evaluated at the trial state, so that costs compare.
            self.evaluation.states.accept()
            self.evaluation.guard()
            self._now.trial_cost = self.evaluation.cost(self.evaluation.states.current)
            self.evaluation.states.accept()
        else:
            self._now.trial_cost = self.evaluation.cost(1 - self.evaluation.states.current)
        self._now.accepted = self._now.trial_cost < self.current_cost
        self._lap(COST)

    # --- damping -----------------------------------------------------------------------------

    cdef void _next_damping(self) noexcept nogil:
        cdef double floor = self._settings.lambda_floor
        cdef double gain = (self._now.cost - self._now.trial_cost) / self._now.predicted
        if self._settings.dogleg:
            if self.dogleg.known:
                self.dogleg.adapt(self._now.accepted, gain)
            else:
                self.dogleg.regularise()
            self.damping = self._now.next_damping = self.dogleg.regularisation
            return
        if self._settings.damping == CUSTOM:
            with gil:
                self._drive()
        elif self._settings.damping == NIELSEN:
            self._nielsen(gain, 1.0 / 3.0)
        elif self._settings.damping == GAIN:
            self._nielsen(gain, 0.1)
        elif self._now.accepted:
            self.damping *= 0.2
        else:
            self.damping *= 10
        if self.damping < floor:
            self.damping = floor
        self._now.next_damping = self.damping

    cdef void _nielsen(self, double gain, double least) noexcept nogil:
        cdef double shape
        if not self._now.accepted:
            self.damping *= self._growth
            self._growth *= 2
            if self._growth > GROWTH_LIMIT:
                self._status = DRIVER_TERMINATED
            return
        shape = 2 * gain - 1
        self.damping *= max(least, 1 - shape * shape * shape) if isfinite(gain) else least
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
        elif self.evaluation.guarded and self._settings.by_promise:
            self.evaluation.guard()
        self._keep_promise()
        verdict = self._verdict()
        self._take_failure()
        if self._settings.watched and self._failure is None:
            with gil:
                self._show()
        self._now.retry += not self._now.accepted
        if verdict != RUNNING and self._status != ABORTED:
            self._status = verdict

    cdef void _keep_promise(self) noexcept nogil:
        """Of the attempts with one linearisation, what the least damped promised."""
        if not self._now.factored and not self.dogleg.known:
            return
        if self._now.retry == 0 or not self.predicted_decrease >= self._now.promise:
            self.predicted_decrease = self._now.promise

    cdef int _verdict(self) noexcept nogil:
        cdef Settings* s = &self._settings
        cdef double before = self._now.cost
        cdef int found
        if s.by_promise:
            if self._now.accepted and s.cost_threshold > 0 and (
                self.current_cost <= s.cost_threshold
            ):
                return COST_THRESHOLD
            found = self._by_promise()
            if found != RUNNING:
                return found
        elif self._now.accepted:
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
            if s.dogleg and self.dogleg.known and self._now.retry >= 2 and (
                self.dogleg.radius <= self._epsilon * sqrt(self._energy)
                or self.dogleg.radius < 1e-300
            ):
                return CONVERGED if self._promise_is_noise() else STALLED
            if s.retry_budget > 0 and self._now.retry >= s.retry_budget:
                return RETRY_BUDGET
        return RUNNING

    cdef int _by_promise(self) noexcept nogil:
        """Whether the linearisation promises no decrease that could be noticed.

        The promise ``g' H^-1 g`` of an undamped step bounds what any step can bring, and every
        scaled entry of the gradient. Where the step was damped, an undamped one is tried first.
        """
        cdef Settings* s = &self._settings
        if not self._now.factored and not self.dogleg.known:
            return RUNNING
        if not self._now.accepted:
            self._jitter[self._now.retry % 3] = fabs(self._now.trial_cost - self._now.cost)
        if not self._now.promise <= max(
            max(s.rel_precision * self._now.cost, s.abs_precision), self.noise_floor
        ):
            self._small_steps = 0
            return RUNNING
        if self._now.damping > PROOF or (
            s.min_diagonal > 0 and self._added > 0.5 * self._now.promise
        ):
            if not s.dogleg and s.lambda_floor < PROOF and not self._proven:
                self._proven = True  # once a linearisation: it may fail
                self.damping = s.lambda_floor
            return RUNNING
        self._small_steps += self._now.accepted
        if self._now.accepted and (
            self.accepted < s.min_iters or self._small_steps <= s.patience
        ):
            return RUNNING
        return CONVERGED

    cdef bint _promise_is_noise(self) noexcept nogil:
        """Whether costs at states that hardly differ scatter by more than is promised.

        Where the cost jumps, by a guard over parameters or a condition within a formula, it rises
        by nearly the same at each of them, which is no scatter.
        """
        cdef double least = INFINITY, most = 0
        cdef int k
        if self.evaluation.guarded:
            return False
        for k in range(3):
            if not isfinite(self._jitter[k]):
                return False
            least, most = min(least, self._jitter[k]), max(most, self._jitter[k])
        return most - least > 0.1 * most and self._now.promise <= 4 * most

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
