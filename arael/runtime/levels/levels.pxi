"""Solver by levels: exact rows, then soft rows, then closeness to a given state.

A lower level moves only in what the higher ones leave free. Directions of the second level are
projected onto the null space of the exact rows; its linear problems are solved there by CGLS, whose
every product with the projector is two solves with the factor that the exact rows have anyway
(J. Nocedal, S. Wright, "Numerical Optimization", 2nd ed., 2006, section 16.3 and chapter 18;
A. Bjorck, "Numerical Methods for Least Squares Problems", 1996, section 7.4). After every step the
exact rows are solved again, so that a lower level never costs accuracy in a higher one.
"""

import numpy as np

from libc.math cimport INFINITY, sqrt
from libc.stdint cimport int32_t, uint8_t
from libc.string cimport memcpy

from arael.runtime.address cimport address, writable
from arael.runtime.compiled cimport Interruption
from arael.runtime.levenberg.clock cimport seconds as clock

from arael.runtime.levels.outcome import ComponentOutcome, Outcome, STATUSES
from arael.runtime.levels.structure import analyse

# Squared sine of the angle between an equation and the span of others below which it is redundant.
PIVOT_TOLERANCE = 1e-12

cdef class Levels(LowerLevels):
    """Solves exact rows; below them soft rows, and closeness to a state.

    Parameters
    ----------
    rows : Rows
        Equations that must hold: r(x) = 0.
    soft : Rows, optional
        Rows whose sum of squares `minimise` makes small, as far as the equations allow.
    guards : Rows, optional
        Functions of x whose signs a solve keeps; where one is zero at its start, it may take any.
    scales : (n,) array_like, optional
        Typical sizes of the unknowns: steps are shortest in x / scales.
    step_limit : int
        Evaluations of the rows in one solve of the exact rows.
    pivot_tolerance : float
        Squared sine of the angle between a row of the Jacobian and the span of other rows below
        which it is taken as redundant.
    shortest : float
        Rows of the Jacobian that are shorter, in scaled unknowns, hold nothing: their entries
        cancel out up to rounding.
    interruption : Interruption, optional
        Requests to break off, shared with other solvers; they last until they are withdrawn.
        By default the solver's own: requests then concern the solve in progress only.

    Notes
    -----
    The analysis is kept until the pattern, the fixed unknowns, or the active rows change; factors
    are kept from one solve to the next.
    """

    cdef readonly Rows soft
    cdef readonly object scales
    cdef readonly double pivot_tolerance, shortest
    cdef object _key, _touched, _low, _high, _own
    cdef object _soft_keep, _soft_key
    cdef object _cursor             # rows of the last drag
    cdef bint _shared               # whether others withdraw requests to break off

    def __init__(
        self, Rows rows not None, Rows soft=None, *, Rows guards=None, scales=None,
        int step_limit=100, double pivot_tolerance=PIVOT_TOLERANCE, double shortest=0.0,
        Interruption interruption=None,
    ):
        self.rows, self.soft, self.guards = rows, soft, guards
        for other in (soft, guards):
            if other is not None and other.n != rows.n:
                raise ValueError(f"expected rows of {rows.n} unknowns, found {other.n}")
        self.scales = None if scales is None else np.array(scales, dtype=np.float64)
        self.limit, self.pivot_tolerance, self.shortest = step_limit, pivot_tolerance, shortest
        self._key = None
        self._shared = interruption is not None
        self.interruption = interruption if interruption is not None else Interruption()
        self.deadline = INFINITY

    def interrupt(self):
        """Break off the solve in progress, from another thread.

        It ends before its next step with the status ``interrupted``, and x is put back. With an
        interruption of its own, a solver that is not at work ignores it.
        """
        self.interruption.raised = 1

    # ---- analysis

    def _analyse(self, fixed, active, basic):
        """Renew the analysis if what it depends on has changed; whether it was renewed."""
        rows, guards = self.rows, self.guards
        versions = rows.pattern_version, guards.pattern_version if guards is not None else -1
        key = self._key
        if (
            key is not None and key[0] == versions
            and _same(key[1], fixed) and _same(key[2], active) and _same(key[3], basic)
        ):
            return False
        n, m = rows.n, rows.m
        free = np.ones(n, bool) if fixed is None else ~fixed
        used = np.ones(m, bool) if active is None else active
        links = None if guards is None else _pattern(guards)
        earlier = None if self.factor is None else self.factor.structure
        structure = analyse(n, *_pattern(rows), free, used, links, earlier)
        scales = np.ones(n) if self.scales is None else self.scales
        if scales.shape != (n,) or not (np.isfinite(scales) & (scales > 0)).all():
            raise ValueError(f"expected {n} positive scales of unknowns")
        factor = RowFactor(
            n, m, structure, np.where(free, scales, 0.0), basic, self.pivot_tolerance,
            self.shortest,
        )
        self.prepare(factor, self.limit)
        self._own = {
            "touched": np.arange(factor.components, dtype=np.int32),
            "start": np.zeros(n), "home": np.zeros(n),
        }
        self._soft_key = self._touched = None
        self._key = (
            versions, None if fixed is None else fixed.copy(),
            None if active is None else active.copy(), None if basic is None else basic.copy(),
        )
        return True

    @property
    def components(self):
        """Number of components found by the last analysis."""
        return 0 if self.factor is None else self.factor.components

    @property
    def component_of(self):
        """(n,) component of each unknown, -1 where it is fixed or in no active row."""
        return self.factor.structure.component_of

    def redundant(self):
        """Rows that had no pivot in the last factors: they depend on others at that point."""
        return self.factor.dropped()

    def _parts_touched(self, touched):
        """Components to be solved, as int32."""
        if touched is None:
            return np.arange(self.factor.components, dtype=np.int32)
        touched = np.asarray(touched)
        found = np.unique(self.factor.structure.component_of[touched])
        return found[found >= 0].astype(np.int32)

    def _begin(self, x, tolerance, fixed, active, basic, low, high):
        """Check arguments and make everything ready."""
        n, m = self.rows.n, self.rows.m
        if not self._shared:
            self.interruption.raised = 0
        if not isinstance(x, np.ndarray) or x.dtype != np.float64 or x.shape != (n,):
            raise ValueError(f"expected x as an array of {n} float64, which is changed in place")
        fixed, active = _mask(fixed, n, "fixed unknowns"), _mask(active, m, "active rows")
        self._analyse(fixed, active, _mask(basic, m, "basic rows"))
        if np.ndim(tolerance) == 0:
            tolerance = np.full(m, tolerance)
        given = np.ascontiguousarray(tolerance, dtype=np.float64)
        if given.shape != (m,) or not _copy_positive(given, self.tolerance, m):
            raise ValueError(f"expected one positive tolerance, or one for each of {m} rows")
        if (low is None) != (high is None):
            low = np.full(n, -np.inf) if low is None else low
            high = np.full(n, np.inf) if high is None else high
        if low is None:
            self.low = self.high = NULL
        else:
            self.low = <double*>writable(self._keep["low"], np.float64)
            self.high = <double*>writable(self._keep["high"], np.float64)
            self._bound(x, _numbers(low, n), _numbers(high, n), fixed)
        self.factors = self.linearisations = 0
        self.stopped, self._failure = False, None

    cdef object _bound(self, x, low, high, fixed):
        """Copy the bounds; bring unknowns that are not fixed within them."""
        cdef Py_ssize_t i, n = self.rows.n
        cdef double* at = <double*>writable(x, np.float64, n)
        cdef const double* least = <const double*>address(low, np.float64, n)
        cdef const double* most = <const double*>address(high, np.float64, n)
        cdef const uint8_t* held = NULL
        if fixed is not None:
            held = <const uint8_t*>address(fixed, np.bool_, n)
        for i in range(n):
            if not least[i] <= most[i]:
                raise ValueError("expected lower bounds that are not above the upper ones")
            self.low[i], self.high[i] = least[i], most[i]
            if held == NULL or not held[i]:
                if at[i] < least[i]:
                    at[i] = least[i]
                elif at[i] > most[i]:
                    at[i] = most[i]

    def _finish(self, parts, **more):
        """Make the outcome of the components; raise what rows in Python raised."""
        for rows in (self.rows, self.guards, self.target):
            if rows is not None:
                rows.check(-1)
        if self._failure is not None and not isinstance(self._failure, KeyboardInterrupt):
            raise self._failure
        cdef const int32_t* at = <const int32_t*>address(parts, np.int32)
        cdef Py_ssize_t j, worst = -1
        cdef int steps = 0, status = SOLVED, guard = -1
        cdef double largest = -1.0
        cdef Component* p
        left = []
        for j in range(len(parts)):
            p = &self.part[at[j]]
            steps = max(steps, p.steps)
            if not p.largest <= largest:
                largest, worst = p.largest, p.row
            if p.status != SOLVED:
                if status == SOLVED:
                    status = p.status
                    guard = p.guard if STATUSES[status] == "side" else -1
                left.append(ComponentOutcome(
                    at[j], STATUSES[p.status], self.r[p.row] if p.row >= 0 else 0.0, p.row,
                    p.guard if STATUSES[p.status] == "side" else -1, p.steps,
                ))  # fmt: skip
        if status != SOLVED:
            worst = left[0].row
        more.setdefault("status", STATUSES[status])
        return Outcome(
            largest=self.r[worst] if worst >= 0 else 0.0, row=worst, guard=guard, steps=steps,
            rounds=self.rounds, factors=self.factors, open=tuple(left),
            history=self.trace_rows(), **more,
        )

    # ---- exact rows

    def solve(
        self, x, tolerance=1e-10, *, fixed=None, active=None, basic=None, touched=None,
        low=None, high=None, keep=False,
    ):
        """Solve the exact rows in place, by steps of least norm.

        Parameters
        ----------
        x : (n,) float64
            Start and result. A component whose rows all hold is not changed by a single bit; one
            that is not solved is put back, unless `keep`.
        tolerance : float or (m,) array_like
            Largest residual of a row that holds.
        fixed : (n,) bool, optional
            Unknowns that do not move.
        active : (m,) bool, optional
            Rows that count; all by default.
        basic : (m,) bool, optional
            Rows that steps are made from, for instance those found independent by a QR; the others
            are only checked. By default rows without a pivot are left out of each factor.
        touched : array of int, optional
            Unknowns whose components are solved; all components by default.
        low, high : (n,) array_like, optional
            Bounds on unknowns; x is clipped to them first.
        keep : bool
            Leave x where the solve ended, solved or not.

        Returns
        -------
        Outcome

        Raises
        ------
        ValueError
            If an argument has another shape than expected.
        """
        self._begin(x, tolerance, fixed, active, basic, low, high)
        parts = self._own["touched"] if touched is None else self._parts_touched(touched)
        cdef double* at = <double*>writable(x, np.float64, self.rows.n)
        cdef const int32_t* of = <const int32_t*>address(parts, np.int32)
        cdef double* start = <double*>writable(self._own["start"], np.float64)
        cdef Py_ssize_t count = len(parts), j, k, c
        cdef RowFactor factor = self.factor
        cdef bint put_back = not keep
        with nogil:
            memcpy(start, at, factor.n * sizeof(double))
            for j in range(count):
                self.restart(of[j], at)
            self.solve_parts(at, of, count)
            for j in range(count):
                c = of[j]
                if self.part[c].status != SOLVED:
                    self.part[c].factored = False
                    if put_back:
                        for k in range(factor.unknown_start[c], factor.unknown_start[c + 1]):
                            at[factor.unknown_list[k]] = start[factor.unknown_list[k]]
        return self._finish(parts)

    # ---- lower levels

    def minimise(
        self, x, tolerance=1e-10, *, home=None, soft_tolerance=None, fixed=None, active=None,
        basic=None, low=None, high=None, limit=100,
    ):
        """Solve the exact rows; among their solutions make the soft rows' sum of squares least.

        Parameters
        ----------
        x : (n,) float64
            Start and result.
        home : (n,) array_like, optional
            Of all optima, come to the one closest to this state.
        soft_tolerance : float, optional
            Soft rows not larger than this are not improved; the smallest `tolerance` by default.
        limit : int
            Steps of each lower level.
        tolerance, fixed, active, basic, low, high
            As in `solve`.

        Returns
        -------
        Outcome
            ``solved`` as soon as the exact rows hold; `converged` is whether an optimum was
            reached. If they cannot be solved, x is put back.
        """
        if self.soft is None:
            raise ValueError("expected Levels(rows, soft=...) to minimise soft rows")
        return self._lower(
            self.soft, x, tolerance, home, soft_tolerance, fixed, active, basic, low, high, limit
        )

    def drag(
        self, x, at, target, home=None, tolerance=1e-10, *, fixed=None, active=None, basic=None,
        low=None, high=None, limit=60, seconds=None,
    ):
        """Bring unknowns to targets as closely as the exact rows allow, moving little else.

        The exact rows hold; then sum (x[at] - target)^2 is least; then x is closest to `home`.

        Parameters
        ----------
        x : (n,) float64
            Start and result: the last frame. If the exact rows cannot be solved, it is put back.
        at : (k,) array of int
            Unknowns that follow the cursor.
        target : (k,) array_like
            Where they should be.
        home : (n,) array_like, optional
            The state when the drag began.
        limit : int
            Steps of each lower level in this frame.
        seconds : float, optional
            Time for the lower levels of this frame, after which the last state that is better is
            kept: the exact rows hold, `converged` is false, and the next frame goes on from there.
            One step is made in any case.
        tolerance, fixed, active, basic, low, high
            As in `solve`.
        """
        rows = self._cursor
        if rows is None or rows.n != self.rows.n or not rows.aim(at, target):
            rows = self._cursor = CursorRows(self.rows.n, at, target)
        self.deadline = INFINITY if seconds is None else clock() + <double>seconds
        try:
            return self._lower(
                rows, x, tolerance, home, None, fixed, active, basic, low, high, limit
            )
        finally:
            self.deadline = INFINITY

    def _lower(
        self, Rows soft, x, tolerance, home, soft_tolerance, fixed, active, basic, low, high,
        int limit,
    ):
        self._begin(x, tolerance, fixed, active, basic, low, high)
        n = self.rows.n
        if soft_tolerance is None:
            soft_tolerance = self._tightest() if self.rows.m else float(np.min(tolerance))
        self.soft_tolerance = soft_tolerance
        self._soft_workspace(soft)
        parts = self._soft_keep["live"]
        cdef double* at = <double*>writable(x, np.float64, n)
        cdef double* start = <double*>writable(self._own["start"], np.float64)
        cdef double* towards = NULL
        memcpy(start, at, self.rows.n * sizeof(double))
        if home is not None:
            home = np.ascontiguousarray(home, dtype=np.float64)
            if home.shape != (n,):
                raise ValueError(f"expected a home of {n} unknowns, found {home.shape}")
            towards = <double*>writable(self._own["home"], np.float64)
            memcpy(towards, address(home, np.float64), self.rows.n * sizeof(double))
        cdef Py_ssize_t j
        cdef bint converged = True, exact = True
        cdef double f2 = 0.0, f3 = 0.0
        with nogil:
            for j in range(self.live_count):
                self.restart(self.live[j], at)
            self.solve_parts(at, self.live, self.live_count)
            for j in range(self.live_count):
                exact = exact and self.part[self.live[j]].status == SOLVED
            if exact and not self.stopped:
                converged = self._soft_level(at, limit, True)
                if towards != NULL and not self.stopped and (converged or not self.late()):
                    converged = self._home_level(at, towards, limit) and converged
                self.target.residuals(at, self.r2)
                f2 = sqrt(dot(self.r2, self.r2, self.target.m))
                if towards != NULL:
                    f3 = sqrt(self._distance(at, towards))
                # State of the components at x, for the outcome.
                if self.rows.residuals(at, self.r) >= 0:
                    for j in range(self.live_count):
                        self.measure(
                            self.live[j], self.r, &self.part[self.live[j]].largest,
                            &self.part[self.live[j]].norm, &self.part[self.live[j]].row,
                        )
                        self.part[self.live[j]].status = SOLVED
        more = {"soft": f2, "distance": f3, "converged": bool(converged and exact)}
        if self.stopped or not exact:
            memcpy(at, start, self.rows.n * sizeof(double))
            for j in range(self.live_count):
                self.part[self.live[j]].factored = False
            if self.stopped and exact:
                more["status"] = "interrupted"
        return self._finish(parts, **more)

    def _soft_workspace(self, Rows soft):
        """Workspaces for soft rows, and what they move; kept while their pattern is."""
        self.target = soft
        key = self._soft_key
        if key is not None and key[0] is self._key and key[3] is soft is self._cursor:
            return  # a cursor keeps its unknowns
        indices = _pattern(soft)[1]
        if key is not None and key[0] is self._key and key[1] == soft.m and (
            np.array_equal(key[2], indices)
        ):
            return
        factor, n = self.factor, self.rows.n
        structure = factor.structure
        component_of = structure.component_of
        scale = self._keep["scale"]
        used = np.unique(indices[scale[indices] > 0]).astype(np.int64)
        found = np.unique(component_of[used])
        live = found[found >= 0].astype(np.int32)
        inside = np.zeros(factor.components + 1, bool)
        inside[live] = True
        mask = inside[component_of]
        mask[used] = True
        mask &= scale > 0
        guards = self.guards.m if self.guards is not None else 0
        self._soft_keep = {
            "live": live, "moving": np.flatnonzero(mask).astype(np.int32),
            **{name: np.zeros(size) for name, size in {
                "r2": soft.m, "e2": len(indices), "left": soft.m, "image": soft.m, "w": n,
                "search": n, "gradient": n, "moved": n, "further": n, "toward": n, "before": n,
                "way": n, "signs": guards,
            }.items()},
            "firm": np.zeros(n, np.uint8),
        }  # fmt: skip
        keep = self._soft_keep
        self.live = <int32_t*>writable(keep["live"], np.int32)
        self.moving = <int32_t*>writable(keep["moving"], np.int32)
        self.live_count, self.moving_count = len(live), len(keep["moving"])
        self.r2 = <double*>writable(keep["r2"], np.float64)
        self.e2 = <double*>writable(keep["e2"], np.float64)
        self.left = <double*>writable(keep["left"], np.float64)
        self.image = <double*>writable(keep["image"], np.float64)
        self.w = <double*>writable(keep["w"], np.float64)
        self.search = <double*>writable(keep["search"], np.float64)
        self.gradient = <double*>writable(keep["gradient"], np.float64)
        self.moved = <double*>writable(keep["moved"], np.float64)
        self.further = <double*>writable(keep["further"], np.float64)
        self.toward = <double*>writable(keep["toward"], np.float64)
        self.before = <double*>writable(keep["before"], np.float64)
        self.way = <double*>writable(keep["way"], np.float64)
        self.firm = <uint8_t*>writable(keep["firm"], np.uint8)
        self.sign = <double*>writable(keep["signs"], np.float64)
        self._soft_key = self._key, soft.m, indices.copy(), soft

    cdef double _tightest(self) noexcept:
        """The smallest tolerance of a row."""
        cdef double found = self.tolerance[0]
        cdef Py_ssize_t i
        for i in range(1, self.rows.m):
            found = min(found, self.tolerance[i])
        return found


cdef bint _copy_positive(given, double* to, Py_ssize_t size) except *:
    """Copy numbers; whether all of them are positive."""
    cdef const double* values = <const double*>address(given, np.float64, size)
    cdef Py_ssize_t i
    for i in range(size):
        if not values[i] > 0.0:
            return False
        to[i] = values[i]
    return True


cdef object _numbers(given, Py_ssize_t size):
    """An array of `size` float64, contiguous."""
    if isinstance(given, np.ndarray) and given.dtype == np.float64 and given.shape == (size,):
        return np.ascontiguousarray(given)
    return np.ascontiguousarray(np.broadcast_to(np.asarray(given, dtype=np.float64), (size,)))


def _mask(given, Py_ssize_t size, what):
    """A boolean mask, or None."""
    if given is None:
        return None
    given = np.ascontiguousarray(given)
    if given.dtype != bool or given.shape != (size,):
        raise ValueError(f"expected {what} as {size} booleans, found {given.dtype} {given.shape}")
    return given


def _pattern(rows):
    """Pattern of rows as arrays; attributes of a typed object would be the pointers."""
    return rows.indptr, rows.indices


def _same(a, b):
    return a is b if a is None or b is None else np.array_equal(a, b)
