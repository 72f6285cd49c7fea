"""Newton's method for underdetermined equations: steps of least norm, per component.

A step is d = -S V' (V V')^-1 W r (see `factor.pxd`). While residuals shrink fast, the factor of an
earlier point is used again (simplified Newton; P. Deuflhard, "Newton Methods for Nonlinear
Problems", 2004, sections 2.1 and 3.1); far from a solution steps are shortened, then damped as in
Levenberg's method. All touched components take their steps at the same time, so that the rows are
evaluated once for all of them, but each is accepted, shortened and ended by itself.
"""

import numpy as np

from cpython.exc cimport PyErr_CheckSignals
from libc.math cimport fabs, isfinite, sqrt
from libc.stdint cimport int32_t, uint8_t
from libc.string cimport memcpy

from arael.runtime.address cimport writable
from arael.runtime.levenberg.clock cimport seconds

# Contraction of the residuals up to which the factor is used again, and up to which a step with a
# factor of another point is taken at all.
cdef double FAST = 0.1
cdef double USEFUL = 0.5
# Share of the way to a guard's boundary that a step may go.
cdef double TO_BOUNDARY = 0.9
# Residuals relative to their tolerance below which another step gains nothing.
cdef double AT_ROUNDING = 1e-5
# Steps after the tolerance was met.
cdef int POLISHING = 3
cdef double SIGNAL_INTERVAL = 0.02


cdef class Newton:
    """Exact rows of a system; `Levels` is its use from Python."""

    def prepare(self, factor, limit):
        """Take workspaces for a factor; what earlier ones held is lost."""
        self.factor = factor
        self.factor.interruption = self.interruption
        self.limit = limit
        cdef Py_ssize_t n = factor.n, m = factor.m, guards = self.guards.m if self.guards else 0
        cdef Py_ssize_t entries = self.rows.indptr[self.rows.m] if self.rows.m else 0
        self._parts = np.zeros((max(factor.components, 1), sizeof(Component)), np.uint8)
        self.part = <Component*>writable(self._parts, np.uint8)
        sizes = {
            "tolerance": m, "scale": n, "r": m, "tried_r": m, "entries": entries, "d": n,
            "trial": n, "guard": guards, "tried_guard": guards, "trace": 3 * (limit + 1),
            "low": n, "high": n,
        }  # fmt: skip
        self._keep = {name: np.zeros(size) for name, size in sizes.items()}
        self._keep["held"] = np.zeros(n, np.uint8)
        self._keep["released"] = np.zeros(n, np.uint8)
        self.tolerance = <double*>writable(self._keep["tolerance"], np.float64)
        self.scale = <double*>writable(self._keep["scale"], np.float64)
        self.r = <double*>writable(self._keep["r"], np.float64)
        self.tried_r = <double*>writable(self._keep["tried_r"], np.float64)
        self.entries = <double*>writable(self._keep["entries"], np.float64)
        self.d = <double*>writable(self._keep["d"], np.float64)
        self.trial = <double*>writable(self._keep["trial"], np.float64)
        self.guard = <double*>writable(self._keep["guard"], np.float64)
        self.tried_guard = <double*>writable(self._keep["tried_guard"], np.float64)
        self.trace = <double*>writable(self._keep["trace"], np.float64)
        self.held = <uint8_t*>writable(self._keep["held"], np.uint8)
        self.released = <uint8_t*>writable(self._keep["released"], np.uint8)
        memcpy(self.scale, self.factor.scale, n * sizeof(double))
        self.low = self.high = NULL

    cdef bint measure(
        self, Py_ssize_t c, const double* r, double* largest, double* norm, int* row
    ) noexcept nogil:
        """Largest residual relative to its tolerance, and the norm; whether all are finite."""
        cdef Py_ssize_t k, i
        cdef double size, total = 0.0, worst = -1.0
        row[0] = -1
        for k in range(self.factor.component_start[c], self.factor.component_start[c + 1]):
            i = self.factor.row_of[k]
            if not isfinite(r[i]):
                row[0] = <int>i
                return False
            total += r[i] * r[i]
            size = fabs(r[i]) / self.tolerance[i]
            if size > worst:
                worst, row[0] = size, <int>i
        largest[0], norm[0] = worst, sqrt(total)
        return True

    cdef void restart(self, Py_ssize_t c, const double* x) noexcept nogil:
        """Begin a solve of a component at x; its factor is kept."""
        cdef Component* p = &self.part[c]
        cdef Py_ssize_t k, i
        for k in range(self.factor.unknown_start[c], self.factor.unknown_start[c + 1]):
            i = self.factor.unknown_list[k]
            self.released[i] = 0
            if self.held[i] and (
                self.low == NULL or x[i] != (self.low[i] if self.held[i] == 1 else self.high[i])
            ):
                self.held[i] = 0
                self.factor.scale[i] = self.scale[i]
                p.factored = False
        p.status, p.steps, p.guard = RUNNING, 0, -1
        p.retries = p.slow = p.limited = p.polished = 0
        p.kept, p.renew, p.polishing, p.cut = p.factored and p.factored_mu == 0, True, False, False
        p.mu, p.along = 0.0, 1.0

    cdef int solve_parts(
        self, double* x, const int32_t* parts, Py_ssize_t count
    ) noexcept nogil:
        """Solve components that were restarted, in place; 0, or -1 if it was stopped."""
        cdef Py_ssize_t j, c, running = 0
        cdef Component* p
        cdef bint due
        cdef int code = self.rows.residuals(x, self.r)
        cdef double worst
        if code < 0:
            self.stopped = True
            return -1
        if self.guards is not None and self.guards.residuals(x, self.guard) < 0:
            self.stopped = True
            return -1
        self.rounds = 0
        for j in range(count):
            c = parts[j]
            p = &self.part[c]
            if not self.measure(c, self.r, &p.largest, &p.norm, &p.row):
                p.status = NOT_FINITE
            elif p.largest <= 1.0:
                p.status = SOLVED
            else:
                running += 1
        memcpy(self.trial, x, self.factor.n * sizeof(double))
        while running:
            if self.rounds >= self.limit or self.interrupted():
                for j in range(count):
                    p = &self.part[parts[j]]
                    if p.status == RUNNING:
                        p.status = (
                            SOLVED if p.polishing
                            else INTERRUPTED if self.stopped else STEP_LIMIT
                        )
                return -1 if self.stopped else 0
            due = False
            worst = 0.0
            for j in range(count):
                p = &self.part[parts[j]]
                if p.status == RUNNING:
                    due = due or (p.renew and not p.kept)
                    worst = max(worst, p.largest)
            self.trace[3 * self.rounds] = worst
            self.trace[3 * self.rounds + 1] = self.factors
            if due:
                code = self.rows.linearise(x, self.r, self.entries)
                self.linearisations += 1
                if code < 0:
                    self.stopped = True
                    return -1
            for j in range(count):
                c = parts[j]
                if self.part[c].status == RUNNING:
                    if self.part[c].renew:
                        self._direction(c, x)
                    if self.stopped:
                        break
                    if self.part[c].status == RUNNING:
                        self._place(c, x)
            if self.stopped:        # within a factor: there is no step
                continue
            if self.guards is not None and self._shorten(x, parts, count) < 0:
                self.stopped = True
                return -1
            self.rounds += 1
            code = self.rows.residuals(self.trial, self.tried_r)
            if code < 0:
                self.stopped = True
                return -1
            running = 0
            for j in range(count):
                c = parts[j]
                p = &self.part[c]
                if p.status == RUNNING:
                    self._judge(
                        c, x,
                        self.measure(
                            c, self.tried_r, &p.tried_largest, &p.tried_norm, &p.tried_row
                        ),
                    )
                    running += p.status == RUNNING
        return 0

    cdef int refactor(
        self, const double* x, const int32_t* parts, Py_ssize_t count
    ) noexcept nogil:
        """Linearise at x and factor without damping: for projections."""
        cdef Py_ssize_t j, c
        cdef int code = self.rows.linearise(x, self.r, self.entries)
        self.linearisations += 1
        if code != 0:
            return code
        for j in range(count):
            c = parts[j]
            self.factor.load(c, self.entries)
            if not self._factor(c, 0.0):
                return -1
        return 0

    cdef bint _factor(self, Py_ssize_t c, double mu) noexcept nogil:
        """Factor the loaded rows of a component; False, and stopped, if that was broken off."""
        cdef Component* p = &self.part[c]
        p.factored = False
        if self.factor.factor(c, mu) < 0:
            self.stopped = True
            return False
        self.factors += 1
        p.factored, p.factored_mu = True, mu
        return True

    cdef void _direction(self, Py_ssize_t c, double* x) noexcept nogil:
        """The next step of a component into `d`."""
        cdef Component* p = &self.part[c]
        cdef Py_ssize_t k, e, i
        cdef double total
        if not p.kept:
            self.factor.load(c, self.entries)
            if not self._factor(c, p.mu):
                return
        self.factor.step(c, self.r, self.d)
        if self.low != NULL and not p.kept and self.release(c):
            self.factor.load(c, self.entries)
            if not self._factor(c, p.mu):
                return
            self.factor.step(c, self.r, self.d)
        total = 0.0
        for k in range(self.factor.unknown_start[c], self.factor.unknown_start[c + 1]):
            i = self.factor.unknown_list[k]
            total += fabs(self.d[i])
        if not isfinite(total):
            if not p.kept:      # derivatives that are not finite
                p.status = NOT_FINITE
                for k in range(self.factor.component_start[c], self.factor.component_start[c + 1]):
                    for e in range(self.factor.start[k], self.factor.start[k + 1]):
                        if not isfinite(self.entries[self.factor.source[e]]):
                            p.row = self.factor.row_of[k]
                p.factored = False
            else:
                p.factored = p.kept = False
                for k in range(self.factor.unknown_start[c], self.factor.unknown_start[c + 1]):
                    self.d[self.factor.unknown_list[k]] = 0.0
        p.renew, p.along, p.cut, p.retries = False, 1.0, False, 0

    cdef void _place(self, Py_ssize_t c, const double* x) noexcept nogil:
        """The trial point of a component, inside of its bounds."""
        cdef double along = self.part[c].along
        cdef Py_ssize_t k, i
        cdef double v
        for k in range(self.factor.unknown_start[c], self.factor.unknown_start[c + 1]):
            i = self.factor.unknown_list[k]
            if self.d[i] != 0.0:
                v = x[i] + along * self.d[i]
                if self.low != NULL:
                    if v < self.low[i]:
                        v = self.low[i]
                    elif v > self.high[i]:
                        v = self.high[i]
                self.trial[i] = v
            else:
                self.trial[i] = x[i]

    cdef int _shorten(
        self, const double* x, const int32_t* parts, Py_ssize_t count
    ) noexcept nogil:
        """Shorten the steps of components until no guard changes its sign."""
        cdef Py_ssize_t g, k, _t, c, before
        cdef double fraction
        cdef bint again = True, fresh = False
        cdef Component* p
        for _t in range(60):
            if self.guards.residuals(self.trial, self.tried_guard) < 0:
                return -1
            again = False
            for g in range(self.guards.m):
                if self.guard[g] == 0.0 or self.guard[g] * self.tried_guard[g] > 0.0:
                    continue
                if not fresh:   # values at x; signs are those of the start
                    fresh = True
                    if self.guards.residuals(x, self.guard) < 0:
                        return -1
                # Not finite counts as a change.
                fraction = self.guard[g] / (self.guard[g] - self.tried_guard[g])
                fraction = TO_BOUNDARY * fraction if fraction > 0.0 else 0.1
                fraction = min(max(fraction, 0.1), TO_BOUNDARY)
                before = -1
                for k in range(self.guards.indptr[g], self.guards.indptr[g + 1]):
                    c = self.factor.component_of[self.guards.indices[k]]
                    if c < 0 or c == before or self.part[c].status != RUNNING:
                        continue
                    before = c
                    p = &self.part[c]
                    p.along *= fraction
                    p.cut, p.guard = True, <int>g
                    self._place(c, x)
                    again = True
            if not again:
                return 0
        # Only a function that is not continuous comes here: no step at all.
        for g in range(count):
            c = parts[g]
            if self.part[c].status == RUNNING and self.part[c].cut:
                self.part[c].status = SIDE
                self.part[c].along = 0.0
                self._place(c, x)
        return 0

    cdef void _judge(self, Py_ssize_t c, double* x, bint finite) noexcept nogil:
        """Accept or reject the trial point of a component."""
        cdef Component* p = &self.part[c]
        cdef double contraction
        if p.polishing:
            if finite and p.tried_largest < p.largest:
                contraction = p.tried_largest / p.largest
                self._accept(c, x)
                if contraction > USEFUL:
                    p.status = SOLVED
            else:
                p.status = SOLVED
        elif finite and (
            p.tried_largest <= 1.0
            or p.tried_norm <= p.norm * (USEFUL if p.kept else 1.0 - 1e-4 * p.along)
        ):
            self._accept(c, x)
        else:
            self._reject(c, x)

    cdef void _accept(self, Py_ssize_t c, double* x) noexcept nogil:
        cdef Component* p = &self.part[c]
        cdef Py_ssize_t k, i
        cdef double contraction = p.tried_norm / p.norm if p.norm > 0 else 0.0
        for k in range(self.factor.unknown_start[c], self.factor.unknown_start[c + 1]):
            i = self.factor.unknown_list[k]
            x[i] = self.trial[i]
        for k in range(self.factor.component_start[c], self.factor.component_start[c + 1]):
            i = self.factor.row_of[k]
            self.r[i] = self.tried_r[i]
        p.steps += 1
        p.largest, p.norm, p.row = p.tried_largest, p.tried_norm, p.tried_row
        p.renew = True
        if p.largest <= 1.0:
            # On to rounding level, as long as steps with the factor at hand halve them.
            p.polished += 1
            if p.polished > POLISHING or p.largest <= AT_ROUNDING or p.factored_mu != 0:
                p.status = SOLVED
            p.polishing = p.kept = True
            return
        p.kept = contraction <= FAST and p.factored_mu == 0 and not p.cut
        if self.low != NULL and self.hold(c, self.trial, x):
            p.kept = False
        p.slow = p.slow + 1 if contraction > 0.99 else 0
        p.limited = p.limited + 1 if p.cut else 0
        if p.limited > 12 or (p.cut and p.along < 1e-6):
            p.status = SIDE
        elif p.slow > 12:
            p.status = STALLED
        elif p.mu > 0 and p.along == 1.0:
            p.mu = p.mu / 30 if p.mu > 1e-9 else 0.0

    cdef void _reject(self, Py_ssize_t c, double* x) noexcept nogil:
        cdef Component* p = &self.part[c]
        if p.kept:              # the factor belongs to a point that is too far
            p.kept, p.renew = False, True
            return
        p.retries += 1
        if self.low != NULL and self.hold(c, self.trial, x):
            # What ran into a bound stays there, and the others take a step of their own.
            if self.rows.residuals(x, self.r) < 0:
                self.stopped = True
            if not self.measure(c, self.r, &p.largest, &p.norm, &p.row):
                p.status = NOT_FINITE
            p.renew = True
            return
        if p.retries <= 3 and p.mu == 0:
            p.along *= 0.25
            return
        if p.cut and p.along < 1e-6:
            p.status = SIDE
            return
        p.mu = max(30 * p.mu, 1e-6)
        p.renew = True
        if p.mu > 1e8:
            p.status = SIDE if p.limited else STALLED

    cdef bint hold(self, Py_ssize_t c, const double* at, double* x) noexcept nogil:
        """Hold unknowns whose step has come to a bound at `at`, in x too; whether there are any."""
        cdef Py_ssize_t k, i
        cdef bint found = False
        for k in range(self.factor.unknown_start[c], self.factor.unknown_start[c + 1]):
            i = self.factor.unknown_list[k]
            if self.held[i] or self.scale[i] == 0.0:
                continue
            if at[i] <= self.low[i] and self.d[i] < 0:
                self.held[i], x[i] = 1, self.low[i]
            elif at[i] >= self.high[i] and self.d[i] > 0:
                self.held[i], x[i] = 2, self.high[i]
            else:
                continue
            self.factor.scale[i] = 0.0
            found = True
        return found

    cdef bint release(self, Py_ssize_t c) noexcept nogil:
        """Release held unknowns that the step would move inwards; whether there are any."""
        cdef Py_ssize_t k, t, i, e, found = 0
        cdef double wish
        for k in range(self.factor.unknown_start[c], self.factor.unknown_start[c + 1]):
            i = self.factor.unknown_list[k]
            if not self.held[i] or self.released[i] > 2:
                continue
            wish = 0.0
            for t in range(self.factor.column_start[i], self.factor.column_start[i + 1]):
                e = self.factor.column_position[t]
                wish -= (
                    self.entries[self.factor.source[self.factor.column_entry[t]]]
                    * self.factor.row_scale[e] * self.factor.solution[e]
                )
            if wish > 0.0 if self.held[i] == 1 else wish < 0.0:
                self.held[i] = 0
                self.released[i] += 1
                self.factor.scale[i] = self.scale[i]
                found += 1
        return found > 0

    cdef bint interrupted(self) noexcept nogil:
        cdef double now
        if self.interruption.look():
            self.stopped = True
        if self.stopped:
            return True
        now = seconds()
        if now - self._last_check < SIGNAL_INTERVAL:
            return False
        self._last_check = now
        with gil:
            try:
                PyErr_CheckSignals()
            except BaseException as problem:
                self._failure = problem
                self.stopped = True
        return self.stopped

    cdef bint late(self) noexcept nogil:
        return isfinite(self.deadline) and seconds() >= self.deadline

    def trace_rows(self):
        """(rounds + 1, 3) largest residual relative to tolerance, factors made, damping."""
        return self._keep["trace"].reshape(-1, 3)[: self.rounds].copy()
