"""The parts of one attempt: factorise, propose steps, evaluate them, choose the next damping."""

from libc.math cimport isfinite

from arael.runtime.levenberg.clock cimport seconds
from arael.runtime.levenberg.component cimport Component

# The dogleg gives way to inner iterations after a step that raises the cost so many times, and
# after so many attempts.
cdef double BAD = 1e4
cdef Py_ssize_t MANY_ATTEMPTS = 15
# Part of the cost that is promised where inner iterations begin, at most.
cdef double NEAR_END = 0.01


cdef class Attempt(Partitioned):
    """What an attempt does, step by step; `Minimiser` has the order."""

    cdef bint _may_attempt(self) noexcept nogil:
        """Whether limits of attempts and time leave something to do."""
        cdef Py_ssize_t j, k
        if self.attempts >= self._settings.max_iters:  # no component has made more than all have
            for j in range(self.vectors.active_count):
                k = self.vectors.active[j]
                if (self._components[k].status == RUNNING
                        and self._components[k].attempts >= self._settings.max_iters):
                    self._end(&self._components[k], MAX_ITERATIONS)
        if self._running == 0:
            self._status = self._worst()
        elif seconds() - self._began >= self._settings.time_limit:
            self._status = TIME_LIMIT
        elif self._interrupted():
            self._status = ABORTED
        self._retire()
        return self._status == RUNNING

    cdef bint _factor(self) noexcept nogil:
        cdef Py_ssize_t failed, j
        self._mark = seconds()
        self.vectors.prepare(self._settings.dogleg or self._settings.damping == GAIN)
        failed = self.solver.factor_with(
            self.vectors.values, self.vectors.damped, self.vectors.step)
        self._now.pivot, self._now.factored = failed - 1, failed == 0
        self._factored = failed == 0
        self._lap(FACTOR if self.attempts else FIRST_FACTOR)
        if self.narrowings == 0:
            self.factorisations += 1
            self.factor_seconds = self._phases[FACTOR]
        if failed:
            for j in range(self.vectors.active_count):
                self._components[self.vectors.active[j]].factored = False
            self._blame(failed - 1)
            return False
        self.solver.finish(self.vectors.step)
        self._lap(SOLVE)
        return True

    cdef void _blame(self, Py_ssize_t pivot) noexcept nogil:
        """Let the attempt be that of the component alone whose matrix is not positive definite."""
        cdef Py_ssize_t j, k, failed
        if self._component == NULL or self.solver.raised.any:
            return
        failed = self._component[pivot]
        if self._components[failed].status == RUNNING:
            for j in range(self.vectors.active_count):
                k = self.vectors.active[j]
                self._components[k].tried = k == failed

    cdef void _propose_damped(self) noexcept nogil:
        """The damped step and what it promises."""
        cdef Py_ssize_t j, k
        cdef Component* c
        self.vectors.products()
        for j in range(self.vectors.active_count):
            k = self.vectors.active[j]
            c = &self._components[k]
            c.promise, c.added = -self.vectors.sums[k].slope, self.vectors.sums[k].added
            # Of the exact solution, step' H step = -slope - added.
            c.predicted = -self.vectors.sums[k].slope + self.vectors.sums[k].added
        self.dogleg.clamp()
        for j in range(self.vectors.active_count):
            k = self.vectors.active[j]
            self._components[k].step_length = self.vectors.sums[k].length

    cdef void _look_ahead(self) noexcept nogil:
        """Costs of the trial state; whether the steps are accepted."""
        cdef Py_ssize_t j, k
        cdef bint sound
        cdef Component* c
        self._mark = seconds()
        self.evaluation.states.move(self.vectors.step, self.vectors.threads)
        self._lap(REFRESH)
        if self._settings.guarded and self._settings.by_promise:
            # Guards over parameters are evaluated at the trial state, so that costs compare.
            self.evaluation.states.accept()
            self.evaluation.guard()
            self._take_costs(self.evaluation.states.current)
            self.evaluation.states.accept()
        else:
            self._take_costs(1 - self.evaluation.states.current)
            if self.inner is not None:
                self._iterate_inside()
        sound = not (self.evaluation.raised.any or self.solver.raised.any)
        for j in range(self.vectors.active_count):
            k = self.vectors.active[j]
            c = &self._components[k]
            if c.tried:
                c.trial_cost = self._sums[k]
                c.accepted = sound and c.trial_cost < c.cost
                self._now.accepted |= c.accepted
        self._lap(COST)

    cdef void _iterate_inside(self) noexcept nogil:
        """Solve what is eliminated again, and take the cost of the trial state that this leads to.

        While much is still to be gained, the rest is far from where it ends, and entities would
        adapt to that.
        """
        cdef const Component* c = &self._components[0]
        if not (isfinite(self._sums[0]) and c.promise <= NEAR_END * c.cost):
            return
        self._lap(COST)
        self.inner.improve(
            self.evaluation, self.vectors, tolerance_of(c, &self._settings, self._sums[0]))
        self._lap(LINEARISE)
        self._take_costs(1 - self.evaluation.states.current)

    cdef void _separate(self) noexcept nogil:
        """Go on with damped steps and inner iterations, if entities are eliminated.

        That is once a solve, where the dogleg fails badly or is slow: this is Python.
        """
        cdef Component* c = &self._components[0]
        if c.attempts < MANY_ATTEMPTS and (c.accepted or c.trial_cost <= BAD * c.cost):
            return
        with gil:
            try:
                self.inner, self._separable = self._separable(), None
            except KeyboardInterrupt:
                self._status = ABORTED
            except BaseException as error:
                self._failure, self._status = error, ABORTED
        if self.inner is None:
            return
        self._settings.dogleg, self._settings.damping = False, NIELSEN
        c.known = c.secant = c.paired = c.whole = False
        c.damping = self.damping = max(self._settings.initial_lambda, self._settings.lambda_floor)

    cdef void _next_damping(self, Component* c) noexcept nogil:
        """Move damping or region of a component that was tried."""
        cdef double gain = (c.before - c.trial_cost) / c.predicted
        if not self._settings.dogleg:
            c.verdict = next_damping(c, &self._settings, gain)
            return
        if c.known:
            self.dogleg.adapt(c, gain)
        else:
            self.dogleg.regularise(c)
        c.damping = c.region.regularisation

    cdef void _ask_driver(self) noexcept nogil:
        """Damping by the caller's function, which knows one component."""
        cdef Component* c = &self._components[0]
        if c.tried:
            with gil:
                self._drive()
            c.damping = max(c.damping, self._settings.lambda_floor)
        self.damping = c.damping

    def _drive(self):
        cdef double damping
        try:
            found = self._driver(self._record())
            if found is None:
                self._status = DRIVER_TERMINATED
            else:
                self._components[0].damping = damping = float(found)
                if not isfinite(damping) or damping < 0:
                    raise ValueError(f"the damping driver returned {found!r} for lambda")
        except KeyboardInterrupt:
            self._status = ABORTED
        except BaseException as error:
            self._failure, self._status = error, ABORTED
