# The best step of a trust region in the plane of steepest descent and Gauss-Newton step.

from arael.runtime.levenberg.component cimport Region


# Parts of steepest descent and Gauss-Newton step; whether they were found. `promise` and `added`
# are those of the component.
cdef bint best_in_plane(
    const Region* region, double promise, double added, double* along, double* across
) noexcept nogil
