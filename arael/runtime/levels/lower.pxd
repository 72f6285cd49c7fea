# Levels below the exact rows: soft rows, and closeness to a state.

from libc.stdint cimport int32_t, uint8_t


cdef class LowerLevels(Newton):
    cdef int32_t* live              # components of the lower levels
    cdef Py_ssize_t live_count
    cdef int32_t* moving            # their unknowns, and those of soft rows that no row has
    cdef Py_ssize_t moving_count
    cdef Rows target                # soft rows at work
    cdef double* r2                 # [m2]
    cdef double* e2                 # entries of the soft rows
    cdef double* left               # [m2] of CGLS
    cdef double* image              # [m2]
    cdef double* w                  # [n] result of CGLS
    cdef double* search             # [n]
    cdef double* gradient           # [n]
    cdef double* moved              # [n] trial point of lower levels
    cdef double* further            # [n]
    cdef double* toward             # [n] projected way home
    cdef double* before             # [n] slope of the soft rows
    cdef double* way                # [n] steepest descent that rows and bounds allow
    cdef uint8_t* firm              # [n] bounds that have a multiplier in the soft level
    cdef double* sign               # [guards] at the start of a lower level
    cdef double soft_tolerance
    cdef bint placed                # the soft level ended with the factors of its x

    cdef void _project(self, double* v) noexcept nogil
    cdef void _pull(self, const double* residual, double* v) noexcept nogil
    cdef void _push(self, const double* v, double* residual) noexcept nogil
    cdef double _inner(self, const double* a, const double* b) noexcept nogil
    cdef void _least(self, double damping) noexcept nogil
    cdef double _distance(self, const double* x, const double* home) noexcept nogil
    cdef bint _sides_kept(self, const double* x) noexcept nogil
    cdef bint _restore(self, double* x) noexcept nogil
    cdef double _into(
        self, double* to, const double* x, const double* v, double along
    ) noexcept nogil
    cdef bint _hold_along(self, const double* x, const double* v) noexcept nogil
    cdef bint _at_low(self, const double* x, Py_ssize_t i) noexcept nogil
    cdef bint _at_high(self, const double* x, Py_ssize_t i) noexcept nogil
    cdef double _allowed(self, const double* x, const double* wish, bint soft) noexcept nogil
    cdef bint _is_held(self) noexcept nogil
    cdef bint _factor_again(self) noexcept nogil
    cdef void _keep_free(self, double* v, bint soft) noexcept nogil
    cdef double _cone(self, const double* x, const double* wish, bint soft) except -1.0
    cdef double _slope_left(self, const double* x) noexcept nogil
    cdef double _soft_cone(self, const double* x) noexcept nogil
    cdef bint _soft_level(self, double* x, int limit, bint timed) noexcept nogil
    cdef bint _home_level(self, double* x, const double* home, int limit) noexcept nogil


# Sum of products.
cdef double dot(const double* a, const double* b, Py_ssize_t n) noexcept nogil
