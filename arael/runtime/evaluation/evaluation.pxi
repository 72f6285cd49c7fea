"""Cost, gradient and blocks of a whole problem, shared among threads."""

import numpy as np

from arael.runtime.address cimport writable
from arael.runtime.kernel cimport Lanes
from arael.runtime.parallel.compiled cimport Task, distribute


cdef void cost_of_share(void* job, Py_ssize_t share) noexcept nogil:
    cdef Work* work = <Work*>job
    work.costs[share] = (<Evaluation>work.evaluation)._cost_of_share(share, work.which)


cdef void costs_of_share(void* job, Py_ssize_t share) noexcept nogil:
    cdef Work* work = <Work*>job
    (<Evaluation>work.evaluation)._costs_in_share(
        share, work.which, <ComponentLanes>work.chosen)


cdef void guard_share(void* job, Py_ssize_t share) noexcept nogil:
    (<Evaluation>(<Work*>job).evaluation)._guard_share(share)


cdef void clear_share(void* job, Py_ssize_t share) noexcept nogil:
    cdef Work* work = <Work*>job
    cdef Py_ssize_t shares = (<Evaluation>work.evaluation).shares
    (<Evaluation>work.evaluation).totals.clear(share, shares, work.gradient, work.values)


cdef void linearise_share(void* job, Py_ssize_t share) noexcept nogil:
    cdef Work* work = <Work*>job
    work.costs[share] = (<Evaluation>work.evaluation)._linearise_share(
        share, work.gradient, work.values, <ComponentLanes>work.chosen)


cdef void add_share(void* job, Py_ssize_t share) noexcept nogil:
    cdef Work* work = <Work*>job
    (<Evaluation>work.evaluation).totals.add(share, work.gradient, work.values)


cdef class Evaluation(Groups):
    """What the Levenberg-Marquardt loop asks of a problem; parameters as those of `Groups`."""

    def __init__(self, layout, *args, **kwargs):
        super().__init__(layout, *args, **kwargs)
        self.threads = 1
        self.updating = self.hooked and self.hooks.updates

    def place(self, structure, instances, held_values, diagonal_at):
        super().place(structure, instances, held_values, diagonal_at)
        self.guarded = any(
            group.moving_guard is not None and self.lanes.whole(0, g).n
            for g, group in enumerate(self.groups)
        )

    # --- functions of the caller -------------------------------------------------------------

    cdef void fill(self, int which, bint derivatives, Py_ssize_t g) noexcept nogil:
        if self.hooked:
            with gil:
                self._fill(which, derivatives, g)

    cdef _fill(self, int which, bint derivatives, Py_ssize_t g):
        if self.raised.any:  # what failed is not called again until the failure was raised
            return
        try:
            self.hooks.fill(which, derivatives, g)
        except BaseException as error:
            self.hooks.fail()
            self.raised.keep(error)

    cdef _update(self):
        if self.raised.any:
            return
        try:
            self.hooks.update(self.states.current)
        except BaseException as error:
            self.hooks.fail()
            self.raised.keep(error)

    cdef _add_curvature(self, void* gradient, void* values):
        if self.raised.any:
            return
        try:
            self.hooks.add_curvature(self.totals.views(gradient, values)[1])
        except BaseException as error:
            self.raised.keep(error)

    # --- all groups --------------------------------------------------------------------------

    cdef double cost(self, int which) noexcept nogil:
        cdef double costs[MOST_SHARES]
        cdef double total = 0
        cdef Py_ssize_t g, k
        cdef Work work
        self.fill(which, False, -1)
        if self.shares > 1:
            work.costs, work.which = costs, which
            self._run_shares(cost_of_share, &work)
            for k in range(self.shares):
                total += costs[k]
            self._checked(total)
        for g in range(self.count):
            if self._whole(g):
                total += self.group_cost_at(g, which)
        return total

    cdef void costs(self, int which, ComponentLanes chosen) noexcept nogil:
        cdef Py_ssize_t g, share
        cdef Work work
        self.fill(which, False, -1)
        if self.shares > 1:
            work.which, work.chosen = which, <void*>chosen
            self._run_shares(costs_of_share, &work)
        for g in range(self.count):
            if not self._whole(g):
                continue
            for share in range(self.shares):
                self._costs_of_chosen(g, share, which, chosen)
        self._checked(0)

    cdef void guard(self) noexcept nogil:
        cdef Py_ssize_t g
        cdef Work work
        if not self.guarded:
            return
        if self.shares > 1:
            self._run_shares(guard_share, &work)
        for g in range(self.count):
            if self._whole(g):
                self.guard_group(g)

    cdef double linearise(
        self, void* gradient, void* values, ComponentLanes chosen
    ) noexcept nogil:
        cdef double costs[MOST_SHARES]
        cdef double total = 0
        cdef Py_ssize_t g, k, share
        cdef Work work
        if self.updating:
            with gil:
                self._update()
        self.fill(self.states.current, True, -1)
        self.guard()
        if self.shares == 1:
            self.totals.clear(0, 1, gradient, values)
        else:
            work.gradient, work.values, work.costs = gradient, values, costs
            work.chosen = <void*>chosen
            self._run_shares(clear_share, &work)
            self._run_shares(linearise_share, &work)
            self._run_shares(add_share, &work)
            for k in range(self.shares):
                total += costs[k]
            self._checked(total)
        for g in range(self.count):
            if not self._whole(g):
                continue
            if chosen is None:
                total += self.linearise_group(
                    g, self.lanes.whole(self.states.current, g), gradient, values)
                continue
            for share in range(self.shares):
                total += self._checked(
                    self._linearise_chosen(g, share, gradient, values, chosen))
        if self.hooked:
            with gil:
                self._add_curvature(gradient, values)
        self.totals.hold(gradient, values)
        return total

    cdef bint _whole(self, Py_ssize_t g) noexcept nogil:
        """Whether a group of the cost is in no share."""
        if self.compiled.required(g):
            return False
        return self.shares == 1 or not self.compiled.sharable(g)

    # --- one share of those that threads may run -----------------------------------------------

    cdef void _run_shares(self, Task task, Work* work) noexcept nogil:
        work.evaluation = <void*>self
        distribute(self.threads, self.shares, task, work)

    cdef double _cost_of_share(self, Py_ssize_t share, int which) noexcept nogil:
        cdef double total = 0
        cdef Py_ssize_t g
        for g in range(self.count):
            if self.compiled.sharable(g):
                total += self.compiled.cost(g, self.lanes.part(which, g, share), NULL)
        return total

    cdef void _guard_share(self, Py_ssize_t share) noexcept nogil:
        cdef Py_ssize_t g
        for g in range(self.count):
            if self.compiled.sharable(g):
                self.compiled.guard(g, self.lanes.part(self.states.current, g, share))

    cdef double _linearise_share(
        self, Py_ssize_t share, void* gradient, void* values, ComponentLanes chosen
    ) noexcept nogil:
        cdef double total = 0
        cdef Py_ssize_t g
        for g in range(self.count):
            if not self.compiled.sharable(g):
                continue
            if chosen is None:
                total += self.compiled.linearise(
                    g, self.lanes.part(self.states.current, g, share), gradient, values)
            else:
                total += self._linearise_chosen(g, share, gradient, values, chosen)
        return total

    cdef void _costs_in_share(
        self, Py_ssize_t share, int which, ComponentLanes chosen
    ) noexcept nogil:
        cdef Py_ssize_t g
        for g in range(self.count):
            if self.compiled.sharable(g):
                self._costs_of_chosen(g, share, which, chosen)

    # --- what is chosen of one group and share -----------------------------------------------

    cdef void _costs_of_chosen(
        self, Py_ssize_t g, Py_ssize_t share, int which, ComponentLanes chosen
    ) noexcept nogil:
        cdef const GroupCosts* one = &chosen.groups[g]
        cdef Py_ssize_t k
        cdef Lanes lanes
        for k in range(one.ends[share], one.ends[share + 1]):
            lanes = self.lanes.between(which, g, one.runs[2 * k], one.runs[2 * k + 1])
            self.compiled.cost(g, &lanes, one.costs + one.runs[2 * k] * one.width)

    cdef double _linearise_chosen(
        self, Py_ssize_t g, Py_ssize_t share, void* gradient, void* values, ComponentLanes chosen
    ) noexcept nogil:
        cdef const GroupCosts* one = &chosen.groups[g]
        cdef double total = 0
        cdef Py_ssize_t k
        cdef Lanes lanes
        for k in range(one.ends[share], one.ends[share + 1]):
            lanes = self.lanes.between(
                self.states.current, g, one.runs[2 * k], one.runs[2 * k + 1])
            total += self.compiled.linearise(g, &lanes, gradient, values)
        return total

    # --- from Python -------------------------------------------------------------------------

    def total_cost(self):
        """Cost at the accepted state."""
        cdef double cost
        with nogil:
            self.guard()
            cost = self.cost(self.states.current)
        self.raise_failure()
        return cost

    def component_lanes(self, partition):
        """The instances of the problem by component, of which a solve chooses."""
        return ComponentLanes(self, partition)

    def component_costs(self, ComponentLanes chosen):
        """Costs at the accepted state of what is chosen, by component: (components + 1,).

        The last is that of instances that read nothing that is solved for.
        """
        found = np.zeros(chosen.components + 1)
        cdef double[::1] total = found
        with nogil:
            self.guard()
            self.costs(self.states.current, chosen)
            chosen.add(&total[0])
        self.raise_failure()
        return found

    def linearised(self, workspace=None, ComponentLanes chosen=None):
        """Cost, J'r (size,) and the values of J'J (value_count,) at the accepted state.

        They are made in the arrays `workspace` of `workspace()`, whatever these hold by now; in new
        ones if None. Where lanes are `chosen`, what only others contribute to is undefined.
        """
        gradient, values = self.workspace() if workspace is None else workspace
        cdef void* first = writable(gradient, self.dtype, self.totals.gradient_extent)
        cdef void* second = writable(values, self.dtype, self.totals.value_extent)
        cdef double cost
        with nogil:
            cost = self.linearise(first, second, chosen)
        self.raise_failure()
        return cost, gradient[: self.size], values[: self.value_count]

    def group_cost(self, Py_ssize_t g):
        """Cost of one group at the accepted state."""
        cdef double cost
        with nogil:
            self.fill(self.states.current, False, g)
            self.guard()
            cost = self.group_cost_at(g, self.states.current)
        self.raise_failure()
        return cost

    def group_linearised(self, Py_ssize_t g, gradient, values):
        """Cost of one group at the accepted state; its J'r and J'J are added to the arrays.

        `gradient` and `values` are as `workspace` makes them.
        """
        cdef void* first = writable(gradient, self.dtype, self.totals.gradient_extent)
        cdef void* second = writable(values, self.dtype, self.totals.value_extent)
        cdef Lanes lanes = self.lanes.adding(self.states.current, g)
        cdef Py_ssize_t share
        cdef double cost
        with nogil:
            self.fill(self.states.current, True, g)
            self.guard()
            cost = self.linearise_group(g, &lanes, first, second)
            for share in range(self.shares):
                self.totals.add(share, first, second)
        self.raise_failure()
        return cost

    def group_rows(self, Py_ssize_t g):
        """Residuals (n, residuals) and Jacobian entries (n, entries) of one group."""
        cdef Lanes* lanes = self.lanes.whole(self.states.current, g)
        cdef void* first
        cdef void* second
        group = self.groups[g]
        with nogil:
            self.fill(self.states.current, True, g)
            self.guard()
        residuals = np.zeros((lanes.n, group.residuals), dtype=self.dtype)
        entries = np.zeros((lanes.n, len(group.jacobian)), dtype=self.dtype)
        if lanes.n:
            first, second = writable(residuals, self.dtype), writable(entries, self.dtype)
            with nogil:
                self.compiled.rows(g, lanes, first, second)
            self._checked(0)
            self.raise_failure()
        return self._as_they_came(g, residuals), self._as_they_came(g, entries)

    def _as_they_came(self, Py_ssize_t g, found):
        """Rows by instance from rows in the order of the lanes."""
        order = self.orders[g]
        if order is None:
            return found
        rows = np.empty_like(found)
        rows[order] = found
        return rows

    def acting(self, Py_ssize_t g):
        """(n,) bool, which instances of one group act at the accepted state."""
        with nogil:
            self.guard()
        self.raise_failure()
        cdef Py_ssize_t n = self.lanes.whole(self.states.current, g).n
        if self.groups[g].moving_guard is None:
            return np.ones(n, dtype=bool)
        flags = self.lanes.data[g][0][:, -1, :].ravel()
        return self._as_they_came(g, flags[:n] != 0)
