"""Levels below the exact rows: soft rows among their solutions, and closeness to a state.

The soft rows' linear problems are solved in the null space of the exact rows by CGLS; after every
step the exact rows are solved again. `docs/internals/levels.md` says how steps are chosen.
"""

import numpy as np

from libc.math cimport fabs, isfinite, sqrt
from libc.string cimport memcpy, memset


# Part of a gradient or vector that must be left after projection to be more than rounding.
cdef double NO_SLOPE = 1e-9
# Evaluations of the exact rows after a step of a lower level.
cdef int RESTORING = 15
# Where steps end by their limit: what counts as an optimum nevertheless.
cdef double NEARLY = 1e-6
# Distance from a bound, relative to the unknown's size, at which it is at the bound.
cdef double AT_BOUND = 1e-14
# Slope of the distance from home, relative to the distance, at which it counts as least: it is
# then within 1e-8 or so of that, and a state that can be home itself is reached regardless.
cdef double NEAR_HOME = 1e-4


cdef class LowerLevels(Newton):
    """Lower levels on workspaces that `Levels` has prepared; used from C."""

    cdef void _project(self, double* v) noexcept nogil:
        """Onto the null space of the exact rows, in scaled unknowns."""
        cdef Py_ssize_t j
        for j in range(self.live_count):
            self.factor.project(self.live[j], v)

    cdef void _pull(self, const double* residual, double* v) noexcept nogil:
        """Set v to S J2' residual on the moving unknowns."""
        cdef Py_ssize_t i, k
        for k in range(self.moving_count):
            v[self.moving[k]] = 0.0
        for i in range(self.target.m):
            for k in range(self.target.indptr[i], self.target.indptr[i + 1]):
                v[self.target.indices[k]] += self.e2[k] * residual[i]
        for i in range(self.target.m):
            for k in range(self.target.indptr[i], self.target.indptr[i + 1]):
                if self.scale[self.target.indices[k]] == 0.0:
                    v[self.target.indices[k]] = 0.0
        for k in range(self.moving_count):
            v[self.moving[k]] *= self.factor.scale[self.moving[k]]

    cdef void _push(self, const double* v, double* residual) noexcept nogil:
        """Set residual to J2 S v."""
        cdef Py_ssize_t i, k, u
        cdef double total
        for i in range(self.target.m):
            total = 0.0
            for k in range(self.target.indptr[i], self.target.indptr[i + 1]):
                u = self.target.indices[k]
                if self.factor.scale[u] != 0.0:
                    total += self.e2[k] * self.factor.scale[u] * v[u]
            residual[i] = total

    cdef double _inner(self, const double* a, const double* b) noexcept nogil:
        cdef Py_ssize_t k
        cdef double total = 0.0
        for k in range(self.moving_count):
            total += a[self.moving[k]] * b[self.moving[k]]
        return total

    cdef void _least(self, double damping) noexcept nogil:
        """Set w to what makes |J2 S P w - left|^2 + damping |w|^2 least (CGLS from zero).

        Destroys `left`, `image`, `search`, `gradient`.
        """
        cdef Py_ssize_t k, i, _t, rounds = min(self.target.m, self.moving_count, 300) + 3
        cdef double first, gamma, delta, step, new, whole
        for k in range(self.moving_count):
            self.w[self.moving[k]] = 0.0
        self._pull(self.left, self.gradient)
        whole = self._inner(self.gradient, self.gradient)
        self._project(self.gradient)
        gamma = first = self._inner(self.gradient, self.gradient)
        if gamma <= NO_SLOPE * NO_SLOPE * whole:
            return
        for k in range(self.moving_count):
            self.search[self.moving[k]] = self.gradient[self.moving[k]]
        for _t in range(rounds):
            self._push(self.search, self.image)
            delta = dot(self.image, self.image, self.target.m)
            delta += damping * self._inner(self.search, self.search)
            if delta <= 0.0 or not isfinite(delta):
                return
            step = gamma / delta
            for k in range(self.moving_count):
                i = self.moving[k]
                self.w[i] += step * self.search[i]
            for i in range(self.target.m):
                self.left[i] -= step * self.image[i]
            self._pull(self.left, self.gradient)
            self._project(self.gradient)
            for k in range(self.moving_count):
                i = self.moving[k]
                self.gradient[i] -= damping * self.w[i]
            new = self._inner(self.gradient, self.gradient)
            if new <= 1e-24 * first:
                return
            for k in range(self.moving_count):
                i = self.moving[k]
                self.search[i] = self.gradient[i] + new / gamma * self.search[i]
            gamma = new

    cdef double _distance(self, const double* x, const double* home) noexcept nogil:
        """Squared distance from home in scaled unknowns."""
        cdef Py_ssize_t k, i
        cdef double v, total = 0.0
        for k in range(self.moving_count):
            i = self.moving[k]
            v = (home[i] - x[i]) / self.scale[i]
            total += v * v
        return total

    cdef bint _sides_kept(self, const double* x) noexcept nogil:
        """Whether all guards have the signs in `sign` at x."""
        cdef Py_ssize_t g
        if self.guards is None:
            return True
        if self.guards.residuals(x, self.tried_guard) < 0:
            self.stopped = True
            return False
        for g in range(self.guards.m):
            if self.sign[g] != 0.0 and not self.sign[g] * self.tried_guard[g] > 0.0:
                return False
        return True

    cdef bint _restore(self, double* x) noexcept nogil:
        """Solve the exact rows of the live components at x, with the factors at hand."""
        cdef Py_ssize_t j
        cdef int limit = self.limit
        if self.guards is not None and not self._sides_kept(x):
            return False
        for j in range(self.live_count):
            self.restart(self.live[j], x)
        # A step that takes longer to put right is better made shorter.
        self.limit = min(limit, RESTORING)
        self.solve_parts(x, self.live, self.live_count)
        self.limit = limit
        if self.stopped:
            return False
        for j in range(self.live_count):
            if self.part[self.live[j]].status != SOLVED:
                return False
        return True

    cdef double _into(
        self, double* to, const double* x, const double* v, double along
    ) noexcept nogil:
        """Set `to` to x + along S v, shortened at the first bound; the fraction that was gone."""
        cdef Py_ssize_t k, i, first = -1
        cdef double step
        if self.low != NULL:
            for k in range(self.moving_count):
                i = self.moving[k]
                step = along * self.factor.scale[i] * v[i]
                if x[i] + step < self.low[i]:
                    along *= (self.low[i] - x[i]) / step
                    first = i
                elif x[i] + step > self.high[i]:
                    along *= (self.high[i] - x[i]) / step
                    first = i
        memcpy(to, x, self.factor.n * sizeof(double))
        for k in range(self.moving_count):
            i = self.moving[k]
            to[i] = x[i] + along * self.factor.scale[i] * v[i]
            if self.low != NULL:
                to[i] = min(max(to[i], self.low[i]), self.high[i])
        if first >= 0:          # exactly at the bound: rounding left of it would end the next step
            to[first] = self.low[first] if v[first] < 0.0 else self.high[first]
        return along

    cdef bint _hold_along(self, const double* x, const double* v) noexcept nogil:
        """Hold unknowns at a bound that the direction v would cross; whether there are any."""
        cdef Py_ssize_t k, i
        cdef bint found = False
        if self.low == NULL:
            return False
        for k in range(self.moving_count):
            i = self.moving[k]
            if self.held[i] or v[i] == 0.0:
                continue
            if (v[i] < 0.0 and self._at_low(x, i)) or (v[i] > 0.0 and self._at_high(x, i)):
                self.held[i] = 1 if v[i] < 0 else 2
                self.factor.scale[i] = 0.0
                found = True
        return found

    cdef bint _at_low(self, const double* x, Py_ssize_t i) noexcept nogil:
        return x[i] - self.low[i] <= AT_BOUND * max(fabs(x[i]), self.scale[i])

    cdef bint _at_high(self, const double* x, Py_ssize_t i) noexcept nogil:
        return self.high[i] - x[i] <= AT_BOUND * max(fabs(x[i]), self.scale[i])

    cdef double _allowed(self, const double* x, const double* wish, bint soft) noexcept nogil:
        """Project a wish onto the directions that exact rows and bounds allow, into `way`.

        These are a cone: unknowns at a bound may only move inwards. The projection is the wish
        without a part in the row space and non-negative multipliers of the bounds (J. J. Moreau,
        1962). Unknowns whose multiplier is positive are held from here on, all others are not:
        the factors have to be made anew. `wish` and `way` are in scaled unknowns; the factors and
        derivatives have to be those of x.

        With `soft` the directions do not change the soft rows, nor the unknowns whose bounds have
        a positive multiplier in the soft level.

        Returns
        -------
        Length of the projection relative to that of the wish: zero at an optimum; -1 if stopped.
        """
        cdef Py_ssize_t j, k, i
        cdef double whole = sqrt(self._inner(wish, wish)), part
        cdef bint changed = False
        if whole == 0.0:
            return 0.0
        for k in range(self.moving_count):
            i = self.moving[k]
            if not soft:
                self.firm[i] = 0
            if self.held[i] and not self.firm[i]:
                self.held[i] = 0
                self.factor.scale[i] = self.scale[i]
                changed = True
        if changed and not self._factor_again():
            return -1.0
        with gil:
            try:
                part = self._cone(x, wish, soft)
            except BaseException as problem:
                self._failure = problem
                self.stopped = True
                return -1.0
        for j in range(self.live_count):
            self.part[self.live[j]].factored = False
        return part / whole

    cdef bint _is_held(self) noexcept nogil:
        """Whether a bound holds an unknown that the soft level does not need there."""
        cdef Py_ssize_t k
        for k in range(self.moving_count):
            if self.held[self.moving[k]] and not self.firm[self.moving[k]]:
                return True
        return False

    cdef bint _factor_again(self) noexcept nogil:
        """Factor the derivatives at hand for the present scales."""
        cdef Py_ssize_t j
        for j in range(self.live_count):
            self.factor.load(self.live[j], self.entries)
            if not self._factor(self.live[j], 0.0):
                return False
        return True

    cdef void _keep_free(self, double* v, bint soft) noexcept nogil:
        """Project v onto the null space of the exact rows, and with `soft` of the soft rows."""
        cdef Py_ssize_t k
        for k in range(self.moving_count):
            if self.factor.scale[self.moving[k]] == 0.0:
                v[self.moving[k]] = 0.0
        self._project(v)
        if soft:
            self._push(v, self.left)
            self._least(0.0)
            for k in range(self.moving_count):
                v[self.moving[k]] -= self.w[self.moving[k]]

    cdef double _cone(self, const double* x, const double* wish, bint soft) except -1.0:
        """Length of the projection of a wish, see `_allowed`, which has released the bounds."""
        cdef Py_ssize_t k, j, i, count = 0
        cdef double size
        cdef double* v = self.way
        cdef double[::1] b = np.empty(self.moving_count)
        cdef double[:, ::1] columns
        cdef double[::1] multipliers
        bounded = []
        for k in range(self.moving_count):
            i = self.moving[k]
            if self.held[i]:
                continue
            if self._at_low(x, i):
                bounded.append((i, 1.0))
            elif self._at_high(x, i):
                bounded.append((i, -1.0))
            v[i] = wish[i]
        self._keep_free(v, soft)
        for k in range(self.moving_count):
            b[k] = v[self.moving[k]]
        columns = np.zeros((self.moving_count, len(bounded)))
        for i, sign in bounded:
            for k in range(self.moving_count):
                v[self.moving[k]] = 0.0
            v[i] = sign
            self._keep_free(v, soft)
            size = sqrt(self._inner(v, v))
            if size > NO_SLOPE:          # else the rows alone hold it
                for k in range(self.moving_count):
                    columns[k, count] = v[self.moving[k]] / size
            count += 1
        size = sqrt(dot(&b[0], &b[0], self.moving_count)) if self.moving_count else 0.0
        multipliers = np.zeros(count)
        if count and size > 0.0:
            # Imported here for start-up time: needed at bounds only.
            from scipy.optimize import nnls

            multipliers = nnls(np.asarray(columns), -np.asarray(b) / size)[0] * size
        for k in range(self.moving_count):
            for j in range(count):
                b[k] += columns[k, j] * multipliers[j]
            v[self.moving[k]] = b[k]
        j = 0
        for i, sign in bounded:
            if multipliers[j] > 0.0:
                self.held[i] = 1 if sign > 0.0 else 2
                self.firm[i] = not soft
                self.factor.scale[i] = 0.0
                v[i] = 0.0
            elif v[i] * sign < 0.0:
                v[i] = 0.0
            j += 1
        return sqrt(self._inner(v, v))

    cdef double _slope_left(self, const double* x) noexcept nogil:
        """How much of the soft level's slope rows and bounds leave at x; -1 if stopped."""
        if self.refactor(x, self.live, self.live_count) != 0:
            return -1.0
        if self.target.linearise(x, self.r2, self.e2) != 0:
            self.stopped = self.target.raised is not None
            return -1.0
        return self._soft_cone(x)

    cdef double _soft_cone(self, const double* x) noexcept nogil:
        """`_allowed` for the slope of the soft rows at x."""
        cdef Py_ssize_t i, k
        memset(self.before, 0, self.factor.n * sizeof(double))
        for i in range(self.target.m):
            for k in range(self.target.indptr[i], self.target.indptr[i + 1]):
                self.before[self.target.indices[k]] -= self.e2[k] * self.r2[i]
        for k in range(self.moving_count):
            i = self.moving[k]
            self.before[i] *= self.scale[i]
        return self._allowed(x, self.before, False)

    cdef bint _soft_level(self, double* x, int limit, bint timed) noexcept nogil:
        """Make the soft rows' sum of squares least, on the exact rows; whether it converged."""
        cdef Py_ssize_t k, i, _t
        cdef double damping = 0.0, f2, new, predicted, slope, curvature, along, whole, norm, size, v
        cdef double stretch = 1.0, left = 1.0
        cdef bint renew = True, asked = False, straight
        cdef int retries
        self.placed = False
        if self.guards is not None:
            self.guards.residuals(x, self.sign)
        retries = 0
        for _t in range(limit):
            if self.interrupted():
                return False
            if timed and _t > 0 and self.late():
                return self.low == NULL and left <= NEARLY
            if renew:
                if self.refactor(x, self.live, self.live_count) != 0:
                    return False
                if self.target.linearise(x, self.r2, self.e2) != 0:
                    self.stopped = self.target.raised is not None
                    return False
            f2 = dot(self.r2, self.r2, self.target.m)
            if f2 <= self.soft_tolerance * self.soft_tolerance:
                self.placed = renew
                for k in range(self.moving_count):
                    self.firm[self.moving[k]] = 0
                return True
            for i in range(self.target.m):
                self.left[i] = -self.r2[i]
            self._pull(self.left, self.gradient)
            whole = sqrt(self._inner(self.gradient, self.gradient))
            self._project(self.gradient)
            norm = sqrt(self._inner(self.gradient, self.gradient))
            straight = False
            if self.low != NULL:
                size = 0.0      # of the slope, bounds or not
                for i in range(self.target.m):
                    for k in range(self.target.indptr[i], self.target.indptr[i + 1]):
                        v = self.e2[k] * self.r2[i] * self.scale[self.target.indices[k]]
                        size = max(size, fabs(v))
                whole = max(whole, size)
                if norm <= NEARLY * whole:
                    # The least on the bounds that are held: others may be the right ones.
                    straight = asked
                    left = self._soft_cone(x)
                    if left < 0.0:
                        return False
                    if left <= NO_SLOPE:
                        return True
                    renew = True
                    if not asked:
                        asked = True
                        continue
            elif norm <= NO_SLOPE * whole or whole == 0.0:
                self.placed = renew
                return True
            if straight:
                # Bounds stop the step of Gauss and Newton at x, but not the projected slope.
                if not self._factor_again():
                    return False
                self._push(self.way, self.image)
                size = dot(self.image, self.image, self.target.m)
                along = -dot(self.image, self.r2, self.target.m) / size if size > 0.0 else 1.0
                if damping > 0.0:
                    along = size * along / (size + damping * self._inner(self.way, self.way))
                for k in range(self.moving_count):
                    self.w[self.moving[k]] = along * self.way[self.moving[k]]
            else:
                left = norm / whole
                self._least(damping)
                if self._hold_along(x, self.w):
                    renew = True
                    continue
            # The model along w, and its slope.
            self._push(self.w, self.image)
            slope = 2.0 * dot(self.image, self.r2, self.target.m)
            size = dot(self.image, self.image, self.target.m)
            predicted = -(slope + size)
            norm = self._inner(self.w, self.w)
            if norm == 0.0:
                return self.low == NULL or self._slope_left(x) <= NO_SLOPE
            along = self._into(self.moved, x, self.w, stretch)
            renew = False
            if not self._restore(self.moved):
                if self.stopped:
                    return False
                damping = max(8.0 * damping, 2.0 * size / norm)
                retries += 1
                if retries > 25:
                    break
                stretch = 1.0
                for k in range(self.live_count):    # the factor may be of another point by now
                    self.part[self.live[k]].factored = False
                renew = True
                continue
            if self.target.residuals(self.moved, self.left) != 0:
                self.stopped = self.target.raised is not None
                if self.stopped:
                    return False
                new = f2 * 2 + 1
            else:
                new = dot(self.left, self.left, self.target.m)
            renew = True
            # Curvature along w beyond that of Gauss and Newton becomes the damping.
            curvature = (new - f2 - along * slope) / (along * along) - size
            if new < f2:
                memcpy(x, self.moved, self.factor.n * sizeof(double))
                retries = 0
                asked = False
                damping = max(0.0, curvature / norm)
                if damping * norm < 1e-3 * size:
                    damping = 0.0
                # Less curvature than that of Gauss and Newton: the next step is longer.
                stretch = 1.0
                if curvature < -1e-3 * size:
                    stretch = size / max(size + curvature, 0.05 * size)
                if f2 - new <= 1e-15 * f2:
                    if self.low != NULL:
                        break
                    return True
                continue
            retries += 1
            if predicted <= 1e-14 * f2:     # below rounding of the sum
                if self.low != NULL:
                    break
                return True
            if retries > 25:
                break
            stretch = 1.0
            damping = max(max(4.0 * damping, size / norm), curvature / norm)
        if self.low == NULL:
            return left <= NEARLY
        left = self._slope_left(x)
        return 0.0 <= left <= NEARLY

    cdef bint _home_level(self, double* x, const double* home, int limit) noexcept nogil:
        """Come as close to home as the levels above allow; whether it converged."""
        cdef Py_ssize_t k, i, _t, _tried
        cdef double f2, new2, f3, new3, along = 1.0, whole, norm, slack, left, ss, sy, v
        cdef double reach
        cdef bint first = True, asked = False, straight, accepted
        self.target.residuals(x, self.r2)
        f2 = sqrt(dot(self.r2, self.r2, self.target.m))
        slack = max(f2 * (1.0 + 1e-9), 10.0 * self.soft_tolerance)
        for _t in range(limit):
            if self.interrupted() or (_t > 0 and self.late()):
                return False
            # the level above has just made the factors of where it ended
            if not self.placed:
                if self.refactor(x, self.live, self.live_count) != 0:
                    return False
                if self.target.linearise(x, self.r2, self.e2) != 0:
                    return False
            self.placed = False
            f3 = reach = 0.0
            for k in range(self.moving_count):
                i = self.moving[k]
                reach = max(reach, max(fabs(x[i]), fabs(home[i])) / self.scale[i])
                v = (home[i] - x[i]) / self.scale[i]
                f3 += v * v
                self.further[i] = v if self.factor.scale[i] != 0.0 else 0.0
            whole = sqrt(f3)
            self._project(self.further)
            self._push(self.further, self.left)
            self._least(0.0)
            norm = 0.0
            ss = sy = 0.0
            for k in range(self.moving_count):
                i = self.moving[k]
                self.further[i] -= self.w[i]
                norm += self.further[i] * self.further[i]
                if not first:
                    v = along * self.toward[i]
                    ss += v * v
                    sy += v * (self.toward[i] - self.further[i])
            norm = sqrt(norm)
            straight = False
            if norm <= NEAR_HOME * whole or norm <= 1e-14 * reach:
                if not self._is_held():
                    return True
                for k in range(self.moving_count):
                    i = self.moving[k]
                    self.further[i] = (home[i] - x[i]) / self.scale[i]
                left = self._allowed(x, self.further, True)
                if left < 0.0:
                    return False
                if left <= NEAR_HOME or left * whole <= 1e-14 * reach:
                    return True
                first = True
                straight = asked
                if not asked:
                    asked = True
                    continue
                if not self._factor_again():
                    return False
                memcpy(self.further, self.way, self.factor.n * sizeof(double))
                norm = left * whole
                along = 1.0
            if not straight and self._hold_along(x, self.further):
                continue
            if not first:       # the step of Barzilai and Borwein
                along = ss / sy if sy > 0.25 * ss else 4.0
            along = min(max(along, 0.02), 4.0)
            first = False
            memcpy(self.toward, self.further, self.factor.n * sizeof(double))
            accepted = False
            for _tried in range(12):
                if along * norm <= 1e-14 * reach:
                    break
                self._into(self.further, x, self.toward, along)
                if self._restore(self.further):
                    self._soft_level(self.further, 8, False)
                    if self.stopped:
                        return False
                    self.target.residuals(self.further, self.r2)
                    new2 = sqrt(dot(self.r2, self.r2, self.target.m))
                    new3 = self._distance(self.further, home)
                    if new2 <= slack and new3 < f3 and self._sides_kept(self.further):
                        accepted = True
                        break
                if self.stopped:
                    return False
                along *= 0.3
            if not accepted:
                return not self._is_held() and (norm <= 1e-6 * whole or norm <= 1e-10 * reach)
            memcpy(x, self.further, self.factor.n * sizeof(double))
            asked = False
            if f3 - new3 <= 1e-15 * f3 and not self._is_held():
                return True
        return False


cdef double dot(const double* a, const double* b, Py_ssize_t n) noexcept nogil:
    cdef Py_ssize_t i
    cdef double total = 0.0
    for i in range(n):
        total += a[i] * b[i]
    return total
