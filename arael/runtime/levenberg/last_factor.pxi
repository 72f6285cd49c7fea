"""The end of a solve by the factor of the linearisation before, without one more factorisation."""

from arael.runtime.levenberg.clock cimport seconds
from arael.runtime.levenberg.component cimport Component


cdef class LastFactor(Attempt):
    """What the last factor shows of a new linearisation. `Minimiser` asks it."""

    cdef void _ask_factor(self) noexcept nogil:
        """End where the factor of the linearisation before shows that nothing is left to gain."""
        cdef Py_ssize_t j, k
        cdef Component* c
        self.vectors.turn_back()
        self.solver.solve(self.vectors.step)
        self._take_failure()
        if self._status != RUNNING:
            return
        self.vectors.products()
        self.vectors.take_faded()
        self.dogleg.curvatures(self.vectors.step)
        for j in range(self.vectors.active_count):
            k = self.vectors.active[j]
            c = &self._components[k]
            if c.asked:
                c.verdict = by_last_factor(
                    c, &self._settings, -self.vectors.sums[k].slope, self.dogleg.curvature[k],
                    self.vectors.sums[k].faded)
                self._ending |= c.verdict != RUNNING
        self._lap(SOLVE)
        for j in range(self.vectors.active_count):
            c = &self._components[self.vectors.active[j]]
            if c.asked and c.verdict == CONVERGED:
                self._correct()
                break

    cdef void _correct(self) noexcept nogil:
        """Take the steps that showed an end, where they lower the cost.

        A step with the last factor and the present gradient, of the simplified Newton method: it
        takes neither a linearisation nor a factorisation, and leaves a small part of what was
        promised (Shamanskii, "A modification of Newton's method", 1967). What is reported as
        predicted is what was left before.
        """
        cdef Py_ssize_t j, k
        cdef Component* c
        cdef bint sound, some = False, every = self.vectors.active_count == self._count
        self._mark = seconds()
        self.evaluation.states.move(self.vectors.step, self.vectors.threads)
        self._lap(REFRESH)
        self._take_costs(1 - self.evaluation.states.current)
        sound = not (self.evaluation.raised.any or self.solver.raised.any)
        for j in range(self.vectors.active_count):
            k = self.vectors.active[j]
            c = &self._components[k]
            self._accepts[k] = (
                sound and c.asked and c.verdict == CONVERGED and self._sums[k] < c.cost)
            every &= self._accepts[k]
            if self._accepts[k]:
                some = True
                self.current_cost += self._sums[k] - c.cost
                c.cost = self._sums[k]
        if every:
            self.evaluation.states.accept()
        elif some:
            self.evaluation.states.accept_chosen(self._accepts, self._component)
        if every and self._count == 1:
            self.current_cost = self._components[0].cost
        self._lap(COST)
        self._take_failure()
