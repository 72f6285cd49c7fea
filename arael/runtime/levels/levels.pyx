# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
"""Solves by levels: exact rows first, then points drawn to targets, then closeness to a place.

A step d on the exact rows is that of least norm with ``J d = -r``, from a QR factorisation of J'
(`arael.runtime.orthogonal`), which also copes with dependent rows. The factor is used again while
the residuals shrink fast (simplified Newton method; P. Deuflhard, Newton Methods for Nonlinear
Problems, section 2.1.4). A step is halved until the residuals become smaller and no guard changes
its sign; where that fails, steps are damped: least norm of (d, s) with ``J d + w s = -r``, which is
Levenberg's step. Lower levels move in the null space of J only. Connected components are judged
each by itself, and one whose rows hold is not moved.
"""

import numpy as np

from libc.math cimport INFINITY, fabs, isfinite, sqrt
from libc.stdint cimport int32_t, uint8_t
from libc.string cimport memcpy, memset

from arael.runtime.address cimport address, writable
from arael.runtime.levels.rows cimport Rows
from arael.runtime.orthogonal.rank_qr cimport RankQR

from arael.runtime.levels.outcome import Outcome

cdef enum:
    SATISFIED = 0
    OPEN = 1
    FAILED = 2
    HALVINGS = 24
    PATIENCE = 8    # steps that gain next to nothing

# A factor is used again while a step takes this part of the residuals or less.
cdef double FAST = 0.1
# The decrease of the residuals that a step must give, as a part of what it promises.
cdef double ENOUGH = 0.05


cdef class Levels:
    """Solver on rows; keeps the analysis and the last factor while the pattern stays.

    Parameters
    ----------
    rows : Rows
    guards : Rows, optional
        On the same unknowns: those that are positive at the start of a solve stay so.
    low, high : (n,) float64, optional
        Bounds of unknowns that stand in one row only (slacks of inequalities). The arrays are read
        anew when the pattern changes.
    """

    def __init__(self, Rows rows, Rows guards=None, low=None, high=None):
        self.rows, self.guards = rows, guards
        self.low, self.high = low, high
        self.version = self.guard_version = -1
        self.kept = []
        self.prepare()

    def set_bounds(self, low, high):
        """Other bounds of the unknowns, from the next solve on."""
        self.low, self.high, self.version = low, high, -1

    cdef void* array(self, dtype, Py_ssize_t count) except? NULL:
        made = np.zeros(max(count, 1), dtype=dtype)
        self.kept.append(made)
        return writable(made, dtype)

    cdef prepare(self):
        """Memory and analysis for the present pattern."""
        cdef Rows rows = self.rows
        cdef Py_ssize_t guards = self.guards.pattern_version if self.guards is not None else -1
        if self.version == rows.pattern_version and self.guard_version == guards:
            return
        self.version, self.guard_version = rows.pattern_version, guards
        self.n, self.m = rows.n, rows.m
        self.k = 0 if self.guards is None else self.guards.m
        self.kept, self.current, self.damped = [], False, None
        indptr, indices = np.asarray((<object>rows).indptr), np.asarray((<object>rows).indices)
        self.qr = RankQR(self.m, self.n, indptr, indices)
        count, of_equations, of_unknowns = self.qr.components
        self.components = count
        m, n, k = self.m, self.n, self.k
        self.r = <double*>self.array(np.float64, m)
        self.trial_r = <double*>self.array(np.float64, m)
        self.right = <double*>self.array(np.float64, m)
        self.tolerance = <double*>self.array(np.float64, m)
        self.weight = <double*>self.array(np.float64, m)
        self.active = <uint8_t*>self.array(np.uint8, m)
        self.wanted = <uint8_t*>self.array(np.uint8, m)
        self.was_active = <uint8_t*>self.array(np.uint8, m)
        self.of_row = <int32_t*>self.array(np.int32, m)
        self.entries = <double*>self.array(np.float64, len(indices))
        self.x = <double*>self.array(np.float64, n)
        self.trial = <double*>self.array(np.float64, n)
        self.d = <double*>self.array(np.float64, n + m)
        self.of_unknown = <int32_t*>self.array(np.int32, n)
        self.g = <double*>self.array(np.float64, k)
        self.trial_g = <double*>self.array(np.float64, k)
        self.of_guard = <int32_t*>self.array(np.int32, k)
        self.state = <uint8_t*>self.array(np.uint8, count)
        self.accepted = <uint8_t*>self.array(np.uint8, count)
        self.merit = <double*>self.array(np.float64, count)
        self.trial_merit = <double*>self.array(np.float64, count)
        self.before = <double*>self.array(np.float64, count)
        self.t = <double*>self.array(np.float64, count)
        self.idle = <int32_t*>self.array(np.int32, count)
        self.blocked_by = <int32_t*>self.array(np.int32, count)
        cdef int32_t[::1] equations = of_equations, unknowns = of_unknowns
        cdef int i
        for i in range(self.m):
            self.of_row[i] = equations[i]
        for i in range(self.n):
            self.of_unknown[i] = unknowns[i]
        self._take_guards()
        self._take_bounds(indptr, indices)

    def _take_guards(self):
        """The component of each guard: that of its first unknown."""
        cdef int i
        if self.guards is None:
            return
        for i in range(self.k):
            self.of_guard[i] = -1
            if self.guards.indptr[i + 1] > self.guards.indptr[i]:
                self.of_guard[i] = self.of_unknown[self.guards.indices[self.guards.indptr[i]]]

    def _take_bounds(self, indptr, indices):
        """Unknowns with bounds, each with its row."""
        found = []
        if self.low is not None or self.high is not None:
            low = np.full(self.n, -np.inf) if self.low is None else np.asarray(self.low)[: self.n]
            high = np.full(self.n, np.inf) if self.high is None else np.asarray(self.high)[: self.n]
            row_of = np.repeat(np.arange(self.m), np.diff(indptr))
            for column in np.flatnonzero(np.isfinite(low) | np.isfinite(high)):
                places = np.flatnonzero(indices == column)
                if len(places) == 1:
                    at = int(places[0])
                    found.append((int(column), int(row_of[at]), at, low[column], high[column]))
                elif len(places):
                    raise ValueError(f"unknown {column} has bounds and stands in several rows")
        cdef int i, count = len(found)
        self.bounded = count
        self.slack = <int32_t*>self.array(np.int32, count)
        self.slack_row = <int32_t*>self.array(np.int32, count)
        self.slack_place = <int32_t*>self.array(np.int32, count)
        self.slack_entry = <double*>self.array(np.float64, count)
        self.slack_low = <double*>self.array(np.float64, count)
        self.slack_high = <double*>self.array(np.float64, count)
        for i in range(count):
            self.slack[i], self.slack_row[i], self.slack_place[i] = found[i][:3]
            self.slack_low[i], self.slack_high[i] = found[i][3:]
            self.slack_entry[i] = 0.0

    # --- evaluation, no GIL -------------------------------------------------------------------

    cdef int evaluate(self, double* x, double* r, double* g) noexcept nogil:
        """Residuals and guards at x; 0, or 1 + the first row that is not finite."""
        cdef int code = self.rows.residuals(x, r)
        if code:
            return code
        self.relax(x, r)
        if self.k:
            self.guards.residuals(x, g)
        return 0

    cdef void relax(self, double* x, double* r) noexcept nogil:
        """Slacks that make their rows hold as far as their bounds let them; who acts then."""
        cdef int i, s, row
        cdef double to
        for i in range(self.bounded):
            s, row = self.slack[i], self.slack_row[i]
            if not self.wanted[row] or self.slack_entry[i] == 0.0:
                continue
            to = x[s] - r[row] / self.slack_entry[i]
            to = min(max(to, self.slack_low[i]), self.slack_high[i])
            r[row] += self.slack_entry[i] * (to - x[s])
            x[s] = to
            if self.slack_low[i] < to < self.slack_high[i]:
                r[row] = 0.0

    cdef void measure(self, const double* r, double* merit) noexcept nogil:
        """Length of the residuals of each component."""
        cdef int i
        memset(merit, 0, self.components * sizeof(double))
        for i in range(self.m):
            if self.wanted[i] and self.of_row[i] >= 0:
                merit[self.of_row[i]] += r[i] * r[i]
        for i in range(self.components):
            merit[i] = sqrt(merit[i])

    cdef bint closed(self) noexcept nogil:
        """Set the state of each component; whether none is open."""
        cdef int i
        cdef bint all_closed = True
        for i in range(self.components):
            if self.state[i] != FAILED:
                self.state[i] = SATISFIED
        for i in range(self.m):
            if self.wanted[i] and fabs(self.r[i]) > self.tolerance[i]:
                if self.of_row[i] < 0:
                    continue
                if self.state[self.of_row[i]] != FAILED:
                    self.state[self.of_row[i]] = OPEN
                    all_closed = False
        return all_closed

    cdef int renew(self) noexcept nogil:
        """Linearise and factor at x; 0, or 1 + a row that is not finite."""
        cdef int i, row, code = self.rows.linearise(self.x, self.r, self.entries)
        if code:
            return code
        self.relax(self.x, self.r)
        memcpy(self.active, self.wanted, self.m)
        for i in range(self.bounded):
            row = self.slack_row[i]
            self.slack_entry[i] = self.entries[self.slack_place[i]]
            self.entries[self.slack_place[i]] = 0.0
            # An inequality acts where it is violated.
            if fabs(self.r[row]) <= self.tolerance[row]:
                self.active[row] = 0
        memcpy(self.was_active, self.active, self.m)
        self.factors += 1
        self.current = True
        return self.qr.factor_entries(self.entries, NULL, self.active)

    cdef void step_into(self, double mu) noexcept nogil:
        """d for the open components, by the present factor (mu 0) or damped."""
        cdef int i, p
        cdef double total
        for i in range(self.m):
            self.right[i] = 0.0
            if self.was_active[i] and self.of_row[i] >= 0 and self.state[self.of_row[i]] == OPEN:
                self.right[i] = -self.r[i]
        if mu == 0.0:
            self.qr.least_norm_into(self.right, self.d)
            return
        # [J, w]: of unit unknowns and with weights of the length of each row.
        cdef int at = 0
        for i in range(self.m):
            total = 0.0
            for p in range(self.rows.indptr[i], self.rows.indptr[i + 1]):
                self.widened[at] = self.entries[p]
                total += self.entries[p] * self.entries[p]
                at += 1
            self.widened[at] = mu * (sqrt(total) if total > 0.0 else 1.0)
            at += 1
        self.damped.factor_entries(self.widened, self.scale, self.active)
        self.damped.least_norm_into(self.right, self.d)
        self.factors += 1

    cdef int search(self, bint last) noexcept nogil:
        """Accept d, or a part of it, in every open component; number of components refused.

        `last`: only full steps are tried.
        """
        cdef int i, c, tries, code, open_count, refused = 0
        cdef double part
        self.measure(self.r, self.merit)
        for c in range(self.components):
            self.t[c] = 1.0 if self.state[c] == OPEN else 0.0
            self.accepted[c] = self.state[c] != OPEN
            self.blocked_by[c] = -1
        for tries in range(1 if last else HALVINGS):
            for i in range(self.n):
                self.trial[i] = self.x[i]
                c = self.of_unknown[i]
                if self.t[c] != 0.0:
                    self.trial[i] += self.t[c] * self.d[i]
            code = self.evaluate(self.trial, self.trial_r, self.trial_g)
            if code > 0:
                # Not finite somewhere: everything that is not accepted yet goes less far.
                for c in range(self.components):
                    if not self.accepted[c]:
                        self.t[c] *= 0.5
                continue
            if code < 0:
                return -1
            self.measure(self.trial_r, self.trial_merit)
            for c in range(self.components):
                if not self.accepted[c]:
                    part = 1.0 - ENOUGH * self.t[c]
                    self.accepted[c] = self.trial_merit[c] <= part * self.merit[c]
            for i in range(self.k):
                c = self.of_guard[i]
                if c >= 0 and self.t[c] != 0.0 and self.g[i] > 0.0 and not self.trial_g[i] > 0.0:
                    self.accepted[c] = False
                    self.blocked_by[c] = i
            open_count = 0
            for c in range(self.components):
                if self.state[c] == OPEN and not self.accepted[c]:
                    open_count += 1
                    self.t[c] *= 0.5
            if open_count == 0:
                break
        for c in range(self.components):
            if self.state[c] == OPEN and not self.accepted[c]:
                refused += 1
                self.t[c] = 0.0
        if refused:
            for i in range(self.n):
                if not self.accepted[self.of_unknown[i]]:
                    self.trial[i] = self.x[i]
            if self.evaluate(self.trial, self.trial_r, self.trial_g):
                return -1
        memcpy(self.x, self.trial, self.n * sizeof(double))
        memcpy(self.r, self.trial_r, self.m * sizeof(double))
        if self.k:
            memcpy(self.g, self.trial_g, self.k * sizeof(double))
        self.measure(self.r, self.trial_merit)
        return refused

    cdef int run(self, int most) noexcept nogil:
        """Newton steps until every component is satisfied or failed; their number, or -1."""
        cdef int steps = 0, c, refused
        cdef double mu = 0.0
        cdef bint fresh = False, slow, idle
        if self.closed():
            return 0
        while steps < most:
            if not self.current or (mu == 0.0 and not fresh and steps):
                self.bad_row = self.renew()
                if self.bad_row:
                    return -1
                fresh = True
            self.step_into(mu)
            steps += 1
            refused = self.search(False)
            if refused < 0:
                return -1
            if refused and not fresh and mu == 0.0:
                continue    # an old factor: the next step has its own
            slow = False
            for c in range(self.components):
                if self.state[c] == OPEN and self.accepted[c]:
                    slow |= self.trial_merit[c] > FAST * self.merit[c]
                    idle = self.trial_merit[c] > 0.98 * self.merit[c]
                    self.idle[c] = self.idle[c] + 1 if idle else 0
                    if self.idle[c] >= PATIENCE:
                        self.state[c] = FAILED
            if refused:
                if mu > 1e8:
                    for c in range(self.components):
                        if self.state[c] == OPEN and not self.accepted[c]:
                            self.state[c] = FAILED
                    mu = 0.0
                else:
                    mu = max(10.0 * mu, 1e-3)
                    with gil:
                        self._widen()
            elif mu > 0.0:
                mu = 0.1 * mu if mu > 1e-4 else 0.0
                self.current = False
            if self.closed():
                return steps
            if slow or mu > 0.0:
                fresh = False
                if mu > 0.0 and not refused:
                    self.bad_row = self.renew()
                    if self.bad_row:
                        return -1
                    fresh = True
                if mu == 0.0:
                    self.current = False
        return steps

    def _widen(self):
        """The factorisation of damped steps."""
        if self.damped is not None:
            return
        indptr, indices = np.asarray((<object>self.rows).indptr), np.asarray((<object>self.rows).indices)
        counts = np.diff(indptr)
        wide_ptr = indptr + np.arange(self.m + 1, dtype=np.int32)
        wide = np.empty(len(indices) + self.m, np.int32)
        own = wide_ptr[1:] - 1
        mask = np.ones(len(wide), dtype=bool)
        mask[own] = False
        wide[mask] = indices
        wide[own] = self.n + np.arange(self.m)
        self.damped = RankQR(self.m, self.n + self.m, wide_ptr, wide)
        self.widened = <double*>self.array(np.float64, len(wide))
        self.scale = <double*>self.array(np.float64, self.n + self.m)
        cdef int i
        for i in range(self.n + self.m):
            self.scale[i] = 1.0

    cdef int sharpen(self) noexcept nogil:
        """One further step with the factor there is, kept if it helps: results at rounding level."""
        cdef int i, c
        if not self.current:
            return 0
        for c in range(self.components):
            self.state[c] = SATISFIED if self.before[c] == self.merit[c] else OPEN
        self.measure(self.r, self.merit)
        for c in range(self.components):
            self.state[c] = (
                OPEN if self.before[c] != self.merit[c] and self.merit[c] > 0.0 else SATISFIED
            )
        self.step_into(0.0)
        for i in range(self.n):
            c = self.of_unknown[i]
            self.trial[i] = self.x[i] + (self.d[i] if self.state[c] == OPEN else 0.0)
        if self.evaluate(self.trial, self.trial_r, self.trial_g):
            return 0
        self.measure(self.trial_r, self.trial_merit)
        for i in range(self.n):
            c = self.of_unknown[i]
            if self.state[c] == OPEN and self.trial_merit[c] < self.merit[c]:
                self.x[i] = self.trial[i]
        return self.evaluate(self.x, self.r, self.g)

    # --- for Python ---------------------------------------------------------------------------

    def forget(self):
        """Do not use the last factor again."""
        self.current = False

    def _begin(self, x, tolerance, active):
        """Take over unknowns, tolerances and the rows that are wanted."""
        self.prepare()
        cdef const double* given = <const double*>address(x, np.float64, self.n)
        memcpy(self.x, given, self.n * sizeof(double))
        limits = np.ascontiguousarray(np.broadcast_to(np.float64(tolerance), (self.m,)))
        memcpy(self.tolerance, <const double*>address(limits, np.float64), self.m * sizeof(double))
        on = np.ones(self.m, np.uint8) if active is None else np.ascontiguousarray(active, np.uint8)
        cdef const uint8_t* flags = <const uint8_t*>address(on, np.uint8, self.m)
        cdef int i
        for i in range(self.m):
            if self.wanted[i] != flags[i]:
                self.current = False
                self.wanted[i] = flags[i]
        memset(self.state, 0, self.components)
        memset(self.idle, 0, self.components * sizeof(int32_t))
        if self.bounded and self.slack_entry[0] == 0.0:
            with nogil:
                self.rows.linearise(self.x, self.r, self.entries)
            for i in range(self.bounded):
                self.slack_entry[i] = self.entries[self.slack_place[i]]
        cdef int code
        with nogil:
            code = self.evaluate(self.x, self.r, self.g)
        self.rows.check(code)
        if code == 0:
            self.measure(self.r, self.before)
        self.bad_row = code
        return code

    def solve(self, x, tolerance, active=None, int most=100):
        """Make the rows hold, by steps of least norm.

        Parameters
        ----------
        x : (n,) float64, changed in place where that succeeded; components that are satisfied, and
            those that fail, keep their bits
        tolerance : float or (m,), of residuals
        active : (m,) bool, rows that count; all by default
        most : steps

        Returns
        -------
        Outcome
        """
        cdef double* into = <double*>writable(x, np.float64, self.n)
        cdef int steps, made = self.factors
        if self._begin(x, tolerance, active):
            return Outcome("not_finite", 0, 0, float("inf"), self.bad_row - 1)
        with nogil:
            steps = self.run(most)
            if steps > 0:
                self.sharpen()
        if steps < 0:
            self.rows.check(self.bad_row if self.bad_row < 0 else 0)
        cdef int i
        cdef bint solved = steps >= 0 and self._is_solved()
        if solved:
            for i in range(self.n):
                into[i] = self.x[i]
        return self._outcome(solved, max(steps, 0), most, self.factors - made)

    def _is_solved(self):
        cdef int i
        for i in range(self.m):
            if self.wanted[i] and not fabs(self.r[i]) <= self.tolerance[i]:
                return False
        return True

    def _outcome(self, bint solved, int steps, int most, int factors, double distance=0.0):
        cdef int i, worst = -1, guard = -1
        cdef double largest = 0.0
        for i in range(self.m):
            if self.wanted[i] and (worst < 0 or fabs(self.r[i]) > largest):
                worst, largest = i, fabs(self.r[i])
        if solved:
            return Outcome("solved", steps, factors, largest, worst, -1, distance)
        if worst >= 0 and self.of_row[worst] >= 0:
            guard = self.blocked_by[self.of_row[worst]]
        status = "side" if guard >= 0 else "step_limit" if steps >= most else "stalled"
        return Outcome(status, steps, factors, largest, worst, guard, distance)

    @property
    def state_of_unknowns(self):
        """(n,) unknowns where the last solve ended, whether it succeeded or not."""
        found = np.empty(self.n)
        memcpy(<double*>writable(found, np.float64), self.x, self.n * sizeof(double))
        return found

    @property
    def residuals(self):
        """(m,) residuals where the last solve ended."""
        found = np.empty(self.m)
        memcpy(<double*>writable(found, np.float64), self.r, self.m * sizeof(double))
        return found

    def drag(self, x, at, targets, home, tolerance, active=None, int most=30):
        """Rows exactly; then some unknowns as near to targets as they can be; then all to `home`.

        Each round projects: the pull on the dragged unknowns, and what is left of closeness to
        home, onto the directions that the level above leaves free; then the exact rows are solved
        again from there, and the step is kept if the dragged unknowns came nearer (or stayed as
        near, and everything nearer to home).

        Parameters
        ----------
        x : (n,) float64, changed in place; where the rows cannot be made to hold it stays
        at : (k,) int, unknowns that are pulled
        targets : (k,) float64
        home : (n,) float64, where everything was when the drag began
        tolerance, active : as `solve`

        Returns
        -------
        Outcome
        """
        cdef double* into = <double*>writable(x, np.float64, self.n)
        at = np.asarray(at, dtype=np.int64)
        targets = np.asarray(targets, dtype=np.float64)
        home = np.asarray(home, dtype=np.float64)[: self.rows.n]
        made = self.factors
        first = self.solve(x, tolerance, active)
        if not first.solved:
            return first
        cdef int i
        here = np.array(x[: self.n])
        near = float(np.linalg.norm(targets - here[at]))
        away = float(np.linalg.norm(home - here))
        size = max(near, away, 1e-300)
        steps = first.steps
        part = 1.0
        for round_ in range(most):
            pull, back = self._directions(here, at, targets, home)
            if pull is None:
                break
            step = pull + back
            length = float(np.abs(step).max(initial=0.0))
            if length <= 1e-15 * (np.abs(here).max(initial=0.0) + size):
                break
            found = self._along(here, step, pull, at, targets, home, near, away, part,
                                tolerance, active)
            steps += 1
            if found is None:
                if part < 1e-3:
                    break
                part *= 0.25
                continue
            moved = float(np.abs(found[0] - here).max(initial=0.0))
            here, near, away, part = found
            if moved <= 1e-14 * size:
                break
        self._begin(here, tolerance, active)
        for i in range(self.n):
            into[i] = self.x[i]
        return self._outcome(True, steps, steps + 1, self.factors - made, near)

    def _along(self, here, step, pull, at, targets, home, near, away, part, tolerance, active):
        """A feasible point along a step that is better, with its distances; None if none is."""
        wanted = targets - here[at]
        slope = -2.0 * float(wanted @ pull[at])
        t = part
        for _ in range(8):
            trial = here + t * step
            outcome = self.solve(trial, tolerance, active, 12)
            if outcome.solved:
                closer = float(np.linalg.norm(targets - trial[at]))
                farther = float(np.linalg.norm(home - trial))
                if closer < near * (1.0 - 1e-12) or (
                    closer <= near * (1.0 + 1e-12) + 1e-15 and farther < away * (1.0 - 1e-9)
                ):
                    if t == 1.0 and slope < 0.0:
                        # Where the parabola through both ends has its lowest point: much shorter
                        # than the step where a point turns about a near one.
                        bend = closer * closer - near * near - slope
                        best = -slope / (2.0 * bend) if bend > 0.0 else 1.0
                        if best < 0.7:
                            again = here + best * step
                            outcome = self.solve(again, tolerance, active, 12)
                            if outcome.solved:
                                other = float(np.linalg.norm(targets - again[at]))
                                if other < closer:
                                    return again, other, float(np.linalg.norm(home - again)), 1.0
                    return trial, closer, farther, min(1.0, 2.0 * t)
                bend = (closer * closer - near * near - slope * t) / (t * t)
                best = -slope / (2.0 * bend) if bend > 0.0 and slope < 0.0 else 0.5 * t
                t = min(max(best, 0.05 * t), 0.5 * t)
            else:
                t *= 0.3
        return None

    def _directions(self, here, at, targets, home):
        """The pull on the dragged unknowns and the way home, in what is left free at a point."""
        memcpy(self.x, <const double*>address(here, np.float64), self.n * sizeof(double))
        cdef int code
        with nogil:
            code = self.renew()
        if code:
            return None, None
        units = np.zeros((len(at), self.n))
        units[np.arange(len(at)), at] = 1.0
        free = self.qr.project(units)                  # rows: P e
        square = free[:, at]
        values, vectors = np.linalg.eigh(0.5 * (square + square.T))
        kept = values > 1e-10 * max(values.max(initial=0.0), 1e-300)
        kept &= values > 1e-14
        inverse = (vectors[:, kept] / values[kept]) @ vectors[:, kept].T
        pull = (inverse @ (targets - here[at])) @ free
        back = self.qr.project(home - here - pull)
        back -= (inverse @ back[at]) @ free
        return pull, back
