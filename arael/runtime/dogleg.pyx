# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
"""Powell's dogleg: the path from steepest descent to the Gauss-Newton step, cut at a trust region.

Powell, "A hybrid method for nonlinear equations", 1970, with the scaling of variables of Moré,
"The Levenberg-Marquardt algorithm: implementation and theory", 1978: lengths are measured in
``D^1/2 x``, where D is the largest diagonal of J'J so far. One factorisation serves all attempts
with a linearisation, so a rejected step costs no more than the cost of the trial state.
"""

from libc.math cimport isfinite, sqrt

from arael.runtime.box cimport Box
from arael.runtime.vectors cimport Descent, Sums, Vectors

# Gain ratios below and above which the radius shrinks and grows, and by how much.
cdef double POOR = 0.25
cdef double GOOD = 0.75
cdef double SHRINK_REJECTED = 0.25
cdef double SHRINK_ACCEPTED = 0.5
cdef double GROW = 2


cdef class Dogleg:
    """Trust region whose steps lie on Powell's dogleg.

    Parameters
    ----------
    vectors : Vectors
    box : Box
    floor : float
        Smallest regularisation: without one, rounding decides about directions that nothing holds.
    """

    def __init__(self, Vectors vectors, Box box, double floor):
        self._vectors, self._box = vectors, box
        self.floor = self.regularisation = floor

    cdef void begin(self) noexcept nogil:
        self.known = self._descended = False
        self.regularisation = max(self.floor, 0.1 * self.regularisation)

    cdef void prepare(self) noexcept nogil:
        self._vectors.prepare(self.regularisation, True)

    cdef void regularise(self) noexcept nogil:
        self.regularisation = max(10 * self.regularisation, 1e-15)

    cdef void take_newton(self, double size) noexcept nogil:
        cdef Sums sums = self._vectors.products()
        self._vectors.keep_newton()
        self.promise = -sums.slope
        self._newton_length, self.added = sums.scaled, sums.added
        self.known = True
        if self.radius == 0:
            # A first step no longer than the state is far: beyond, costs tend to be flat.
            self.radius = sqrt(self._newton_length)
            if size > 0:
                self.radius = min(self.radius, size)

    cdef double propose(self) noexcept nogil:
        cdef double along = 0, across = 1, gg, t, newton, corner, gap, product, curvature
        cdef Sums sums
        newton = self._newton_length
        self.length = sqrt(newton)
        if self.length > self.radius:
            self._descend()
            gg = self._descent_length
            t = gg / self._descent_curvature
            if not isfinite(t):
                t = 0
            corner = t * t * gg
            if corner >= self.radius * self.radius:
                along, across = self.radius / sqrt(gg), 0
            else:
                # |corner + s (n - corner)| = radius, of the root that cancels nothing
                product = t * self.promise - corner
                gap = newton - 2 * t * self.promise + corner
                across = (self.radius * self.radius - corner) / (
                    product + sqrt(product * product + gap * (self.radius * self.radius - corner)))
                along = t * (1 - across)
            self.length = self.radius
        self._vectors.combine(along, across)
        if self._box.count > 0 and self._box.clamp(self._vectors.step):
            sums = self._vectors.products()
            self.length = sqrt(sums.scaled)
            return -2 * sums.slope - self._box.curvature(
                self._vectors.values, self._vectors.step)
        curvature = across * across * (self.promise - self.added)
        if along != 0:
            curvature += along * along * self._descent_curvature + 2 * along * across * (
                self._descent_length - self._descent_added)
            return 2 * (along * self._descent_length + across * self.promise) - curvature
        return 2 * across * self.promise - curvature

    cdef void _descend(self) noexcept nogil:
        cdef Descent found
        if self._descended:
            return
        found = self._vectors.take_descent()
        self._descent_length, self._descent_added = found.length, found.added
        self._descent_curvature = self._box.curvature(self._vectors.values, self._vectors.descent)
        self._descended = True

    cdef void adapt(self, bint accepted, double gain) noexcept nogil:
        if not accepted:
            self.radius = SHRINK_REJECTED * self.length
        elif gain > GOOD:
            self.radius = max(self.radius, GROW * self.length)
        elif not gain >= POOR:
            self.radius = SHRINK_ACCEPTED * self.length
