"""Powell's dogleg: the path from steepest descent to the Gauss-Newton step, cut at a trust region.

Powell, "A hybrid method for nonlinear equations", 1970, with the scaling of variables of Moré,
"The Levenberg-Marquardt algorithm: implementation and theory", 1978: lengths are measured in
``D^1/2 x``, where D is the largest diagonal of J'J so far. One factorisation serves all attempts
with a linearisation, so a rejected step costs no more than the cost of the trial state. Each
connected component of the problem has a trust region of its own.

Near an optimum with large residuals, where the Gauss-Newton step converges slowly, a secant step
comes first (levenberg/secant.pxi).
"""

import numpy as np


from libc.math cimport isfinite, sqrt
from libc.stdint cimport int32_t, uint8_t
from libc.string cimport memset

from arael.runtime.address cimport writable
from arael.runtime.levenberg.component cimport Component, Region

# Gain ratios below and above which the radius shrinks and grows, and by how much.
cdef double POOR = 0.25
cdef double GOOD = 0.75
cdef double SHRINK_REJECTED = 0.25
cdef double SHRINK_ACCEPTED = 0.5
cdef double GROW = 2
# Length of a state, relative to the Gauss-Newton step, up to which it limits no first step; nor
# does it where such a step would change the cost by less than so many times its rounding noise.
cdef double NEGLIGIBLE = 1e-8
cdef double VISIBLE = 1e3


cdef class Dogleg:
    """Trust regions whose steps lie on Powell's dogleg; bound to components by `dogleg_of`.

    Attributes
    ----------
    floor : float
        Smallest regularisation: without one, rounding decides about directions that nothing holds.
    """

    @property
    def radius(self):
        """Smallest radius of a component that is being solved, or of all if none is."""
        regions = [
            self._components[k].region.radius for k in range(self._count)
            if self._components[k].status == RUNNING
        ]
        return min(regions or [self._components[k].region.radius for k in range(self._count)])

    cdef void begin(self) noexcept nogil:
        self._descended = False

    cdef void begin_component(self, Component* c) noexcept nogil:
        c.known = False
        c.region.regularisation = max(self.floor, 0.1 * c.region.regularisation)

    cdef void regularise(self, Component* c) noexcept nogil:
        c.region.regularisation = max(10 * c.region.regularisation, 1e-15)

    cdef void take_newton(self) noexcept nogil:
        cdef Py_ssize_t j, k
        cdef Component* c
        cdef Sums* sums
        cdef double size
        self._vectors.products()
        for j in range(self._vectors.active_count):
            k = self._vectors.active[j]
            c, sums = &self._components[k], &self._vectors.sums[k]
            self._vectors.wanted[k] = c.status == RUNNING and not c.known
            if not self._vectors.wanted[k]:
                continue
            c.promise, c.added = -sums.slope, sums.added
            c.region.newton_length = sums.scaled
            c.known = True
            if c.region.radius == 0:
                # A first step no longer than the state is far: beyond, costs tend to be flat.
                size = sqrt(c.energy)
                c.region.radius = sqrt(sums.scaled)
                if (size > NEGLIGIBLE * c.region.radius
                        and 2 * size * c.promise > VISIBLE * c.noise_floor * c.region.radius):
                    c.region.radius = min(c.region.radius, size)
        self._vectors.keep_newton()
        if self._secant:
            self._vectors.secant_sums()

    cdef void propose(self) noexcept nogil:
        cdef Py_ssize_t j, k
        for j in range(self._vectors.active_count):
            k = self._vectors.active[j]
            if self._components[k].tried:
                self._components[k].secant = False
                if not (self._secant and choose_secant(&self._components[k], self._vectors, k)):
                    self._cut_path(k)
        self._vectors.combine()
        if self._secant:
            self._secant = False  # once a linearisation
            self._take_secants()
        if not self.clamp():
            self._vectors.products()
        for j in range(self._vectors.active_count):
            k = self._vectors.active[j]
            self._components[k].step_length = self._vectors.sums[k].length

    cdef void _take_secants(self) noexcept nogil:
        """Complete the secant steps; those that are not sound become steps on the path."""
        cdef Py_ssize_t j, k
        cdef bint again = False
        self._vectors.add_pair()
        self._vectors.products()
        for j in range(self._vectors.active_count):
            k = self._vectors.active[j]
            if self._components[k].secant and not is_sound(
                &self._components[k], self._vectors, k
            ):
                self._cut_path(k)
                again = True
        if again:
            self._vectors.combine()
            self._vectors.add_pair()

    cdef void keep_pairs(self) noexcept nogil:
        self._secant, self._pairs = self._pairs, False
        if self._secant:
            self._vectors.keep_pair()

    cdef bint clamp(self) noexcept nogil:
        cdef Py_ssize_t j, k
        cdef Component* c
        if self._box.count == 0:
            return False
        memset(self._cut, 0, self._count)
        if not self._box.clamp(self._vectors.step, self._component, self._cut):
            return False
        self.curvatures(self._vectors.step)
        self._vectors.products()
        for j in range(self._vectors.active_count):
            k = self._vectors.active[j]
            c = &self._components[k]
            if self._cut[k]:
                c.whole = False
                c.region.length = sqrt(self._vectors.sums[k].scaled)
                c.predicted = -2 * self._vectors.sums[k].slope - self.curvature[k]
        return True

    cdef void _cut_path(self, Py_ssize_t k) noexcept nogil:
        """Where a component's path leaves its region, and what the step promises without bounds."""
        cdef double along = 0, across = 1, curvature
        cdef Component* c = &self._components[k]
        cdef Region* region = &c.region
        region.length = sqrt(region.newton_length)
        c.whole = region.length <= region.radius
        if not c.whole:
            self._descend()
            self._take_path(c, &along, &across)
            region.length = region.radius
        self._vectors.along[k], self._vectors.across[k] = along, across
        curvature = across * across * (c.promise - c.added)
        if along != 0:
            curvature += along * along * region.descent_curvature + 2 * along * across * (
                region.descent_length - region.descent_added)
            c.predicted = 2 * (along * region.descent_length + across * c.promise) - curvature
        else:
            c.predicted = 2 * across * c.promise - curvature

    cdef void _take_path(self, Component* c, double* along, double* across) noexcept nogil:
        """Where the dogleg leaves the region: parts of steepest descent and Gauss-Newton step."""
        cdef Region* region = &c.region
        cdef double gg = region.descent_length, t = gg / region.descent_curvature
        cdef double square = region.radius * region.radius, corner, product, gap
        if not isfinite(t):
            t = 0
        corner = t * t * gg
        if corner >= square:
            along[0], across[0] = region.radius / sqrt(gg), 0
            return
        # |corner + s (n - corner)| = radius, of the root that cancels nothing
        product = t * c.promise - corner
        gap = region.newton_length - 2 * t * c.promise + corner
        across[0] = (square - corner) / (
            product + sqrt(product * product + gap * (square - corner)))
        along[0] = t * (1 - across[0])

    cdef void _descend(self) noexcept nogil:
        """Steepest descent of all components, once a linearisation."""
        cdef Py_ssize_t j, k
        cdef Region* region
        if self._descended:
            return
        self._vectors.take_descent()
        self.curvatures(self._vectors.descent)
        for j in range(self._vectors.active_count):
            k = self._vectors.active[j]
            region = &self._components[k].region
            region.descent_length = self._vectors.sums[k].descent_length
            region.descent_added = self._vectors.sums[k].descent_added
            region.descent_curvature = self.curvature[k]
        self._descended = True

    cdef void curvatures(self, const void* step) noexcept nogil:
        memset(self.curvature, 0, self._count * sizeof(double))
        self._box.curvature(self._vectors.values, step, self._component, self.curvature)

    cdef void adapt(self, Component* c, double gain) noexcept nogil:
        cdef Region* region = &c.region
        c.paired = leaves_pair(c, gain)
        self._vectors.paired[c - self._components] = c.paired
        c.promise_before = c.promise
        self._pairs |= c.paired
        if c.secant and not c.accepted:
            return  # the Gauss-Newton step comes next, in the same region
        if not c.accepted:
            region.radius = SHRINK_REJECTED * region.length
        elif gain > GOOD:
            region.radius = max(region.radius, GROW * region.length)
        elif not gain >= POOR:
            region.radius = SHRINK_ACCEPTED * region.length


cdef Dogleg dogleg_of(
    Vectors vectors, Box box, double floor, components, const int32_t* component
):
    """Trust regions of the components of `vectors`.

    Parameters
    ----------
    components : array that holds a `Component` for each
    component : that of each scalar, or NULL: all are of one
    """
    cdef Dogleg found = Dogleg.__new__(Dogleg)
    cdef Py_ssize_t k
    found._vectors, found._box, found.floor = vectors, box, floor
    found._components = <Component*>writable(components, np.float64)
    found._count, found._component = vectors.components, component
    memory = np.zeros(2 * found._count)
    found._keep = (memory, components)
    found.curvature = <double*>writable(memory, np.float64)
    found._cut = <uint8_t*>(found.curvature + found._count)
    for k in range(found._count):
        found._components[k].region.regularisation = floor
    return found
