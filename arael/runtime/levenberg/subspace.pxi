"""The best step of a trust region in the plane of steepest descent and Gauss-Newton step.

Byrd, Schnabel and Shultz, "Approximate solution of the trust region problem by minimization over
two-dimensional subspaces", Math. Prog. 40, 1988. All that it takes are products of the two vectors,
which the dogleg needs as well.

With c the steepest descent in scaled variables (``D c = -g``) and n the Gauss-Newton step, an
orthonormal basis in the metric D is ``e = c / |c|`` and ``f = (n - m e) / |n - m e|``, where
``m = c'D n / |c|``. The gradient has no part along f.
"""

from libc.math cimport fabs, isfinite, sqrt

from arael.runtime.levenberg.component cimport Region

# A length this near the radius is scaled to it.
cdef double PLANE_TOLERANCE = 1e-3
cdef int PLANE_ITERATIONS = 30


cdef bint best_in_plane(
    const Region* region, double promise, double added, double* along, double* across
) noexcept nogil:
    cdef double size = sqrt(region.descent_length), radius = region.radius
    cdef double m = promise / size, rest = region.newton_length - m * m
    cdef double mixed = (region.descent_length - region.descent_added) / size
    cdef double ee = region.descent_curvature / region.descent_length
    cdef double ef, ff, shift = 0, a, b, pivot, x, y, length, slope
    cdef int _
    if not rest > 1e-12 * region.newton_length:
        return False
    rest = sqrt(rest)
    ef = (mixed - m * ee) / rest
    ff = (promise - added - 2 * m * mixed + m * m * ee) / (rest * rest)
    # (B + shift) (x, y) = (|c|, 0) with B = (ee, ef; ef, ff), and a shift that makes the length
    # equal the radius: Newton's method on 1 / length, from the left, after Hebden.
    for _ in range(PLANE_ITERATIONS):
        a, b = ee + shift, ff + shift
        pivot = a * b - ef * ef
        if not (pivot > 0 and a > 0):
            return False
        x, y = size * b / pivot, -size * ef / pivot
        length = sqrt(x * x + y * y)
        if fabs(length - radius) <= PLANE_TOLERANCE * radius:
            break
        # (x, y)' (B + shift)^-1 (x, y)
        slope = (b * x * x - 2 * ef * x * y + a * y * y) / pivot
        shift += (length - radius) / radius * length * length / slope
        if not shift >= 0:
            return False
    x, y = x * radius / length, y * radius / length
    across[0] = y / rest
    along[0] = (x - m * across[0]) / size
    return isfinite(along[0]) and isfinite(across[0])
