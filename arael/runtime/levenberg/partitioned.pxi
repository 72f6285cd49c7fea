"""The components of a solve: their costs, their ends, and the system without those that ended.

A component that has ended leaves the system: its rows become those of the identity, and blocks of
lanes without others are not evaluated any more. When few are left, solver and passes are narrowed
to them (linear/narrowing.py).
"""

import numpy as np

from libc.stdint cimport int64_t

from arael.runtime.address cimport address, table_address, writable
from arael.runtime.raw cimport bytes_at
from arael.runtime.levenberg.component cimport Component

from arael.runtime.linear import narrowing
from arael.runtime.records import check_record, probe_of
from arael.runtime.evaluation.compiled import rows_of

# What became of a component, as `outcomes.py` takes it.
COMPONENT = np.dtype(
    [
        ("status", np.int64),
        ("iterations", np.int64),
        ("accepted", np.int64),
        ("start_cost", np.float64),
        ("end_cost", np.float64),
        ("predicted_decrease", np.float64),
    ]
)

ended_probe = probe_of(COMPONENT)
check_record("Ended", COMPONENT, (<const Ended*>address(ended_probe, COMPONENT))[0], sizeof(Ended))


cdef class Partitioned(Supervised):
    """What a solve knows of its components. `Minimiser` sets it up."""

    @property
    def components(self):
        """What became of each component, as a structured array of `COMPONENT`."""
        cdef Py_ssize_t k
        cdef Component* c
        found = np.zeros(self._count, dtype=COMPONENT)
        cdef Ended* at = <Ended*>writable(found, COMPONENT)
        for k in range(self._count):
            c = &self._components[k]
            at[k].status, at[k].iterations, at[k].accepted = c.status, c.attempts, c.steps
            at[k].start_cost, at[k].end_cost = c.start_cost, c.cost
            at[k].predicted_decrease = c.predicted_decrease
        return found

    cdef void _take_costs(self, int which) noexcept nogil:
        """Costs of the components at one of the two states, as sums."""
        if self.lanes is None:
            self._sums[0] = self.evaluation.cost(which)
            return
        self.evaluation.costs(which, self.lanes)
        self._empty_sums()
        self._sums[self._count] = 0
        self.lanes.add(self._sums)

    cdef void _take_noise(self) noexcept nogil:
        """Energies, as sums: the noise of the costs follows from them."""
        if self._component == NULL:
            self._sums[0] = self.evaluation.states.energy(
                self.vectors.values, self.evaluation.totals.diagonal_at)
        else:
            self._empty_sums()
            self.evaluation.states.add_energy(
                self.vectors.values, self.evaluation.totals.diagonal_at, self._component,
                self._sums)

    cdef void _empty_sums(self) noexcept nogil:
        cdef Py_ssize_t j
        for j in range(self.vectors.active_count):
            self._sums[self.vectors.active[j]] = 0

    cdef void _keep_noise(self, Component* c, double energy) noexcept nogil:
        c.energy = energy
        c.noise_floor = noise_of(c.cost, energy, self._settings.epsilon)

    cdef void _measure(self) noexcept nogil:
        """Cost of the whole."""
        cdef Py_ssize_t j, k
        self.current_cost = self._settled
        for j in range(self.vectors.active_count):
            k = self.vectors.active[j]
            self.current_cost += self._components[k].cost

    cdef void _end(self, Component* c, int status) noexcept nogil:
        if status != RUNNING:
            c.status = status
            self._running -= 1
            self._retiring = True

    cdef void _retire(self) noexcept nogil:
        """Components that have ended leave the system, if there are others."""
        cdef Py_ssize_t j, k
        cdef Component* c
        if not self._retiring:
            return
        self._retiring = False
        self.vectors.scaled_gradient()
        for j in range(self.vectors.active_count):
            k = self.vectors.active[j]
            c = &self._components[k]
            if c.status != RUNNING:
                c.gradient = self.vectors.sums[k].gradient
                self._settled += c.cost
                self._marks[k] = self._accepts[k] = False
        if self._running > 0:
            self.vectors.leave_out(self._marks)
            self.lanes.choose(self._marks)
            self._empty_retired()

    cdef void _empty_retired(self) noexcept nogil:
        """Couplings of components that have ended are zero, so that their rows are the identity."""
        if self._running < self._count:
            self.vectors.empty_values(self._value_runs, self._value_run_count, self._marks)

    cdef void _count_in_vain(self) noexcept nogil:
        """Narrow where that takes no longer than what was lost; see `narrowing.CONSTANT`."""
        self._in_vain += self._scalars - self.vectors.active_scalars
        if self._in_vain < self._constant + self._multiple * self.vectors.active_scalars:
            return
        if self._scalars == self.vectors.active_scalars:
            return
        with gil:
            try:
                self._narrow()
            except KeyboardInterrupt:
                self._status = ABORTED
            except BaseException as error:
                self._failure, self._status = error, ABORTED

    def _narrow(self):
        """Restrict solver, states, totals and bounds to the components that are left.

        This is Python, and allocates: `_count_in_vain` keeps it rare.
        """
        partition = self._partition
        kept = np.frombuffer(bytes_at(self._marks, self._count), np.bool_).copy()
        runs = np.ascontiguousarray(partition.of_values[kept[partition.of_values[:, 2]]])
        self.solver = narrowing.remaining_solver(self._whole, partition, kept)
        self.narrowings += 1
        self._factored = False
        self.evaluation.states.restrict(partition.of_scalar, kept)
        self.evaluation.totals.restrict(rows_of(kept[partition.of_scalar], 0), runs[:, :2])
        self._box.restrict(partition.of_scalar, kept)
        self._narrowed = runs
        self._value_runs, self._value_run_count = (
            <const int64_t*>table_address(runs, 3), len(runs))
        self._scalars, self._in_vain = self.vectors.active_scalars, 0

    def _widen(self):
        """Undo what `_narrow` did to the problem."""
        self.evaluation.states.restrict()
        self.evaluation.totals.restrict()
        self._box.restrict()

    cdef int _worst(self) noexcept nogil:
        cdef Py_ssize_t k
        cdef int found = self._components[0].status
        for k in range(1, self._count):
            if badness(self._components[k].status) > badness(found):
                found = self._components[k].status
        return found
