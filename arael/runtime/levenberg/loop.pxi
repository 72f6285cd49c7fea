"""The loop of a solve: linearise, propose steps, accept or reject them, decide whether to go on.

The default strategy is a trust region with Powell's dogleg (dogleg.pxi), the other is
Levenberg-Marquardt (damping.pxi). A problem is one or more connected components, which
share linearisation and factorisation; each has its own trust region or damping, and is accepted,
rejected and ended by itself (partitioned.pxi). What one attempt consists of is in attempt.pxi, and
what the last factor says of a linearisation in last_factor.pxi.
"""

import numpy as np

from libc.math cimport NAN, isnan, sqrt
from libc.stdint cimport int32_t, int64_t, uint8_t
from libc.string cimport memset

from arael.runtime.address cimport address, table_address, writable
from arael.runtime.evaluation.compiled cimport Evaluation
from arael.runtime.levenberg.clock cimport seconds
from arael.runtime.levenberg.component cimport Component
from arael.runtime.linear.compiled cimport LinearSolver

from arael.runtime.linear import narrowing


cdef class Minimiser(LastFactor):
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
    partition : Partition, or None
        The components that are solved apart; None: all is one. Custom damping and ends by small
        steps need one.
    separable : function without parameters, or None
        Makes the inner iterations (`InnerSteps`) with which damped steps take the dogleg's place
        where that fails far from the end; or returns None.
    """

    def __init__(self, Evaluation evaluation, LinearSolver solver, Box box, config, watcher,
                 bint watched, partition=None, separable=None):
        if bool(solver.single) != bool(evaluation.single):
            raise ValueError("the linear solver and the problem differ in precision")
        self.evaluation, self.solver, self._box = evaluation, solver, box
        self.watch(watcher, min(config.max_iters, 1024) + 1)
        self._settings = settings_of(
            config, evaluation.dtype, evaluation.guarded, watched, evaluation.size)
        self._exact = solver.plan.get("solver") != "schur_pcg"
        self._separable = separable
        self._driver = config.damping if self._settings.damping == CUSTOM else None
        self._count = self._running = 1
        if partition is not None:
            self._take_partition(partition)
        self.vectors = Vectors(
            evaluation.size, evaluation.totals, evaluation.threads,
            None if partition is None else partition.of_scalar, self._count)
        self._make_components(None if partition is None else partition.guarded)
        self.predicted_decrease = self.gradient_norm = self.noise_floor = NAN

    def _take_partition(self, partition):
        if not self._settings.by_promise or self._driver is not None:
            raise ValueError("one lambda, or an end by small steps, is for one component")
        self._count = self._running = partition.count
        self.lanes = self.evaluation.component_lanes(partition)
        self._component = <const int32_t*>address(
            partition.of_scalar, np.int32, self.evaluation.size)
        self._value_runs = <const int64_t*>table_address(partition.of_values, 3)
        self._value_run_count = len(partition.of_values)
        self._partition, self._whole = partition, self.solver
        self._scalars = self.evaluation.size
        self._constant, self._multiple = narrowing.limits(self.solver)

    def _make_components(self, guarded):
        cdef Py_ssize_t k
        cdef Component* c
        cdef Settings* s = &self._settings
        # One array of doubles for all of these: small problems are solved in microseconds.
        self._memory = np.zeros(
            self._count * (sizeof(Component) // sizeof(double)) + 2 * self._count + 2)
        self._components = <Component*>writable(self._memory, np.float64)
        self._sums = <double*>(self._components + self._count)
        self._marks = <uint8_t*>(self._sums + self._count + 1)
        self._accepts = self._marks + self._count + 1
        memset(self._marks, 1, self._count + 1)
        for k in range(self._count):
            c = &self._components[k]
            c.fresh = True
            c.guarded = s.guarded if guarded is None else guarded[k]
            c.guarded |= self.evaluation.updating  # data differs between linearisations
            c.growth = 2
            c.predicted_decrease = NAN
            c.damping = s.lambda_floor if s.dogleg else max(s.initial_lambda, s.lambda_floor)
        self.damping = self._components[0].damping
        self._box.mark(self._component, &self._components[0].bounded, sizeof(Component))
        self.dogleg = dogleg_of(
            self.vectors, self._box, s.lambda_floor, self._memory, self._component)

    # --- from Python -------------------------------------------------------------------------

    def run(self):
        """Solve; return the status.

        What watcher, driver, native function or linear solver raised passes through.
        """
        try:
            with nogil:
                self._run()
        finally:
            if self.narrowings:
                self._widen()
        if self._failure is not None:
            failure, self._failure = self._failure, None
            raise failure
        return STATUSES[self._status]

    # --- the loop ----------------------------------------------------------------------------

    cdef void _run(self) noexcept nogil:
        self._began = self._mark = self._last_check = seconds()
        self._status = RUNNING
        self._start_components()
        while self._status == RUNNING:
            self._linearise()
            while self._status == RUNNING:
                self._attempt()
                if self._separable is not None and self._status == RUNNING:
                    self._separate()
                if self._now.accepted:
                    break
        self._finish()

    cdef void _start_components(self) noexcept nogil:
        """Costs of the start; a problem that is solved as one has it of the first linearisation."""
        if self.lanes is None:
            return
        self.evaluation.guard()
        self._take_costs(self.evaluation.states.current)
        self._settled = self._sums[self._count]
        self._marks[self._count] = False
        if self._settled != 0:
            self.lanes.choose(self._marks)
        self._start_at_costs()
        self._lap(COST)

    cdef void _start_at_costs(self) noexcept nogil:
        """Begin with the costs in the sums."""
        cdef Py_ssize_t k
        for k in range(self._count):
            self._components[k].cost = self._components[k].start_cost = self._sums[k]
        self._measure()
        self.start_cost = self.current_cost

    cdef void _linearise(self) noexcept nogil:
        """Gradient, blocks and diagonal at the accepted state."""
        cdef Settings* s = &self._settings
        cdef double cost
        self._mark = seconds()
        cost = self.evaluation.linearise(
            self.vectors.gradient, self.vectors.values, self.lanes)
        if self._now.iteration == 0 and self.lanes is None:
            self._sums[0] = cost
            self._start_at_costs()
        elif s.guarded and not s.by_promise:
            # Other instances may act than those the step was judged by.
            self._components[0].cost = self.current_cost = cost
        if self.evaluation.updating:
            self._take_updated_costs()
        if s.by_promise or s.dogleg:
            self._take_noise()
        if self._box.count:
            self._box.hold(self.vectors.gradient, self.vectors.values)
        self._empty_retired()
        self.vectors.take_diagonal(s.min_diagonal)
        self.dogleg.begin()
        self._begin_components()
        self._lap(LINEARISE)
        if self._now.iteration == 1:
            with gil:
                self._start()
        self._take_failure()
        if self._status != RUNNING:
            return
        if s.cost_threshold > 0 and self.current_cost <= s.cost_threshold:
            self._status = COST_THRESHOLD
            return
        if self._asking:
            self._ask_factor()
        self._end_at_linearisation()
        # After the last use of the last factor.
        if self._running < self._count:
            self._count_in_vain()

    cdef void _take_updated_costs(self) noexcept nogil:
        """Costs at the accepted state with the data that the linearisation has changed."""
        cdef Py_ssize_t j, k
        cdef Component* c
        self._take_costs(self.evaluation.states.current)
        self.current_cost = self._settled
        for j in range(self.vectors.active_count):
            k = self.vectors.active[j]
            c = &self._components[k]
            if c.status == RUNNING:
                c.cost = self._sums[k]
                c.fresh = True
                if self._now.iteration == 0:
                    c.start_cost = c.cost
            self.current_cost += c.cost
        if self._now.iteration == 0:
            self.start_cost = self.current_cost

    cdef void _begin_components(self) noexcept nogil:
        """What each has of the new linearisation, and whether it ends with it.

        One pass: with many components each pass reads all of them from memory.
        """
        cdef Py_ssize_t j, k
        cdef Component* c
        cdef bint noise = self._settings.by_promise or self._settings.dogleg
        cdef double largest = 0
        # A component that keeps its Gauss-Newton step may move without a factor: when that of the
        # others failed, or when the loop was narrowed since.
        cdef bint exact = self._exact and self._factored
        self._ending = self._asking = False
        for j in range(self.vectors.active_count):
            k = self.vectors.active[j]
            c = &self._components[k]
            if c.status != RUNNING:
                continue
            largest = max(largest, self.vectors.sums[k].largest)
            if noise:
                self._keep_noise(c, self._sums[k])
            c.verdict = RUNNING
            # One that was rejected is where it was: its steps go on from there.
            if c.fresh:
                c.fresh = False
                self.dogleg.begin_component(c)
                c.proven = c.factored = False
                c.retry = 0
                c.verdict = at_linearisation(
                    c, &self._settings, 2 * self.vectors.sums[k].largest)
                self._ending |= c.verdict != RUNNING
                c.asked = (
                    exact and c.verdict == RUNNING and may_have_ended(c, &self._settings))
                self._asking |= c.asked
            else:
                c.asked = False
        self._now.gradient = 2 * largest
        self._now.iteration += 1
        self._now.retry = 0

    cdef void _end_at_linearisation(self) noexcept nogil:
        cdef Py_ssize_t j
        cdef Component* c
        if not self._ending:
            return
        for j in range(self.vectors.active_count):
            c = &self._components[self.vectors.active[j]]
            if c.status == RUNNING:
                self._end(c, c.verdict)
        self._retire()

    cdef void _attempt(self) noexcept nogil:
        """Damp, factorise, solve, evaluate; accept or reject."""
        cdef double began = seconds()
        cdef Py_ssize_t j, k
        cdef bint known = True  # whether all have their Gauss-Newton step
        cdef Component* c
        self._now.accepted = False
        if not self._may_attempt():
            return
        for j in range(self.vectors.active_count):
            k = self.vectors.active[j]
            c = &self._components[k]
            c.tried, c.accepted, c.verdict = c.status == RUNNING, False, RUNNING
            c.before, c.factored = c.cost, True  # unless the factorisation fails
            c.trial_cost = c.predicted = c.step_length = NAN
            c.damped = c.region.regularisation if self._settings.dogleg else c.damping
            self.vectors.damping[k] = c.damped
            if c.tried and not c.known:
                known = False
        if self._settings.dogleg:
            if known or self._factor():
                self._mark = seconds()
                if not known:
                    self.dogleg.take_newton()
                self.dogleg.propose()
                self._lap(SOLVE)
                self._look_ahead()
        elif self._factor():
            self._mark = seconds()
            self._propose_damped()
            self._lap(SOLVE)
            self._look_ahead()
        self._conclude()
        self._now.seconds = seconds() - began
        self._judge()

    # --- after an attempt --------------------------------------------------------------------

    cdef void _conclude(self) noexcept nogil:
        """The record of the attempt of all together; of each its next damping, and its cost."""
        cdef Py_ssize_t j, k
        cdef Component* c
        cdef Record* now = &self._now
        cdef bint some = now.accepted, custom = self._settings.damping == CUSTOM
        now.cost = self.current_cost
        now.damping = self.damping = 0
        now.trial_cost, now.predicted, now.step_norm = self._settled, 0, 0
        now.promise = 0 if now.factored else NAN
        now.radius = NAN
        self._reached = self._settled
        self._all_accepted = self.vectors.active_count == self._count
        for j in range(self.vectors.active_count):
            k = self.vectors.active[j]
            c = &self._components[k]
            if c.tried:
                now.damping = max(now.damping, c.damped)
                now.promise += c.promise
                if c.known and not now.radius <= c.region.radius:
                    now.radius = c.region.radius
            # What the problem as a whole comes to; if all are rejected, what was tried.
            if c.tried and (c.accepted or not some):
                now.trial_cost += c.trial_cost
                now.predicted += c.predicted
                now.step_norm += c.step_length
            else:
                now.trial_cost += c.cost
            if c.tried and not custom:
                self._next_damping(c)
            self.damping = max(self.damping, c.damping)
            self._accepts[k] = c.accepted
            self._all_accepted &= c.accepted
            if c.accepted:
                c.cost, c.fresh = c.trial_cost, True
                c.steps += 1
            self._reached += c.cost
        now.step_norm = sqrt(now.step_norm)
        if custom:
            self._ask_driver()
        now.next_damping = self.damping

    cdef void _judge(self) noexcept nogil:
        """Take accepted steps over, keep the record, and decide who goes on."""
        cdef Py_ssize_t j, k
        cdef int found
        cdef Component* c
        self._keep_record()
        if self._now.accepted:
            if self._settings.dogleg:
                self.dogleg.keep_pairs()
            self._accept()
        elif self._settings.guarded and self._settings.by_promise:
            self.evaluation.guard()
        self._measure_tried()
        self._ending = False
        for j in range(self.vectors.active_count):
            k = self.vectors.active[j]
            c = &self._components[k]
            if c.tried:
                c.attempts += 1
                found = after_attempt(c, &self._settings)
                if found != RUNNING:
                    c.verdict = found
                self._ending |= c.verdict != RUNNING
                c.retry += not c.accepted
        self._take_failure()
        if self._settings.watched and self._failure is None:
            with gil:
                self._show()
        self._now.retry += not self._now.accepted
        for j in range(self.vectors.active_count if self._ending else 0):
            c = &self._components[self.vectors.active[j]]
            if c.tried:
                self._end(c, c.verdict)
        if self._running == 0 and self._status != ABORTED:
            self._status = self._worst()
        elif (self._status == RUNNING and self._now.accepted and self._settings.cost_threshold > 0
                and self.current_cost <= self._settings.cost_threshold):
            self._status = COST_THRESHOLD
        self._retire()

    cdef void _accept(self) noexcept nogil:
        """The accepted components move, the others stay."""
        if self._all_accepted:
            self.evaluation.states.accept()
        else:
            self.evaluation.states.accept_chosen(self._accepts, self._component)
        self.accepted += 1
        self.current_cost = self._reached

    cdef void _measure_tried(self) noexcept nogil:
        """What only some ends ask for."""
        cdef Py_ssize_t j, k
        if self._settings.parameter_tolerance > 0:
            if self._component == NULL:
                self._components[0].norm = self.evaluation.states.norm()
            else:
                self._empty_sums()
                self.evaluation.states.add_squares(self._component, self._sums)
                for j in range(self.vectors.active_count):
                    k = self.vectors.active[j]
                    self._components[k].norm = sqrt(self._sums[k])
        if not (self._settings.by_promise or self._now.accepted):
            self.vectors.scaled_gradient()
            self._components[0].gradient = self.vectors.sums[0].gradient

    cdef void _finish(self) noexcept nogil:
        """What a result reports of the last linearisations; not computed on the way."""
        cdef Py_ssize_t k
        cdef Component* c
        cdef double energy = 0, left = 0
        if not (self._settings.by_promise or self._settings.dogleg):
            self._take_noise()
            for k in range(self._count):
                if self._components[k].status == RUNNING:
                    self._keep_noise(&self._components[k], self._sums[k])
        for k in range(self._count):
            if self._components[k].status == RUNNING:
                self._end(&self._components[k], self._status)
        self._retire()
        for k in range(self._count):
            c = &self._components[k]
            energy += c.energy
            left += c.gradient
            if isnan(self.predicted_decrease):
                self.predicted_decrease = c.predicted_decrease
            elif not isnan(c.predicted_decrease):
                self.predicted_decrease += c.predicted_decrease
        self.gradient_norm = sqrt(left)
        self.noise_floor = noise_of(self.current_cost, energy, self._settings.epsilon)
