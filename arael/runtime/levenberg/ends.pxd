# Whether a component has ended, and why.

from arael.runtime.levenberg.component cimport Component

# Noise of a cost: rounding of its sum, and of residuals by that of their terms, whose sum of
# squares is `energy`.
cdef double noise_of(double cost, double energy, double epsilon) noexcept nogil
# Whether a new linearisation is an end; `gradient` is the largest entry of the gradient.
cdef int at_linearisation(Component* c, const Settings* s, double gradient) noexcept nogil
# Whether an attempt was the last; it is accepted or rejected by now, and the next damping known.
# Whether it is worth a solve with the factor of the last linearisation to ask `by_last_factor`.
cdef bint may_have_ended(const Component* c, const Settings* s) noexcept nogil
# At a linearisation after a whole step: `promise` is g' H^-1 g of the present gradient and the last
# matrix, `curvature` that of the present matrix along H^-1 g, `faded` what scalars may add whose
# diagonal has fallen.
cdef int by_last_factor(
    Component* c, const Settings* s, double promise, double curvature, double faded) noexcept nogil
cdef int after_attempt(Component* c, const Settings* s) noexcept nogil
# Decreases up to here are not noticeable.
cdef double tolerance_of(const Component* c, const Settings* s, double cost) noexcept nogil
