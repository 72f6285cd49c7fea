# Vector arithmetic of the Levenberg-Marquardt loop, in either precision, sums in f64.

from libc.math cimport fabs, isfinite
from libc.stdint cimport int64_t

ctypedef fused real:
    float
    double


cdef inline void take_diagonal(
    Py_ssize_t n, const real* values, const int64_t* at, double floor, real* diagonal
) noexcept nogil:
    """Undamped diagonal, not under `floor`; NaN stays."""
    cdef Py_ssize_t i
    for i in range(n):
        diagonal[i] = values[at[i]]
        if diagonal[i] < floor:
            diagonal[i] = <real>floor


cdef inline void damp(
    Py_ssize_t n, const real* diagonal, double damping, real* damped
) noexcept nogil:
    cdef Py_ssize_t i
    cdef real factor = <real>(1 + damping)
    for i in range(n):
        damped[i] = diagonal[i] * factor


cdef inline void negate(Py_ssize_t n, const real* x, real* y) noexcept nogil:
    cdef Py_ssize_t i
    for i in range(n):
        y[i] = -x[i]


cdef inline double dot(Py_ssize_t n, const real* x, const real* y) noexcept nogil:
    cdef Py_ssize_t i
    cdef double total = 0
    for i in range(n):
        total += <double>x[i] * <double>y[i]
    return total


cdef inline double largest(Py_ssize_t n, const real* x) noexcept nogil:
    """Largest magnitude; NaN counts for nothing."""
    cdef Py_ssize_t i
    cdef double found = 0
    for i in range(n):
        found = max(found, fabs(<double>x[i]))
    return found


cdef inline double added_curvature(
    Py_ssize_t n, const real* values, const int64_t* at, const real* damped, const real* step
) noexcept nogil:
    """Sum of step_i^2 times what damping (and the floor) added to the diagonal."""
    cdef Py_ssize_t i
    cdef double total = 0
    for i in range(n):
        total += (<double>damped[i] - <double>values[at[i]]) * <double>step[i] * <double>step[i]
    return total


cdef inline double scaled_gradient(
    Py_ssize_t n, const real* gradient, const real* diagonal
) noexcept nogil:
    """Sum of g_i^2 / H_ii: the reduction that single coordinates promise, free of damping."""
    cdef Py_ssize_t i
    cdef double total = 0
    for i in range(n):
        if diagonal[i] > 0:
            total += <double>gradient[i] * <double>gradient[i] / <double>diagonal[i]
    return total


cdef inline Py_ssize_t count_unusable(Py_ssize_t n, const real* x) noexcept nogil:
    """Number of NaN and infinite entries."""
    cdef Py_ssize_t i, found = 0
    for i in range(n):
        found += not isfinite(<double>x[i])
    return found
