# The vectors of one solve, and what the Levenberg-Marquardt loop does with them.

from libc.stdint cimport int64_t

from arael.runtime.pool cimport Task

ctypedef fused real:
    float
    double

cdef enum:
    MOST_PARTS = 16


# Sums over one part of the scalars. `D` is the scale, `H` the undamped matrix, `A` what was added
# to its diagonal.
cdef struct Sums:
    double slope                # g' step
    double length               # step' step
    double scaled               # step' D step
    double added                # step' A step


# Sums over the steepest descent in scaled variables, c = -g / D, and the Gauss-Newton step n.
cdef struct Descent:
    double length               # c' D c = g' c without its sign
    double added                # c' A n


cdef class Vectors:
    cdef readonly bint single   # f32 if true, else f64
    cdef readonly Py_ssize_t n
    cdef readonly int threads   # that share the passes
    # J'r and the values of J'J, each with what lies behind it; the diagonal, not under its floor;
    # that and its damping; the step; the largest diagonal so far; the Gauss-Newton step; steepest
    # descent.
    cdef readonly object gradient_array, value_array, diagonal_array, damped_array, step_array
    cdef readonly object scale_array, newton_array, descent_array
    cdef void* gradient
    cdef void* values
    cdef void* step
    cdef void* damped
    cdef void* scale
    cdef void* newton
    cdef void* descent
    cdef void* _diagonal
    cdef void* _own             # the diagonal as it is in the values
    cdef object _keep
    cdef const int64_t* _at     # [n] offsets of the diagonal in the values
    cdef Py_ssize_t _parts
    cdef double _floor
    cdef double _damping
    cdef bint _by_scale
    cdef double _along, _across         # of descent and Gauss-Newton step in a dogleg
    cdef double[MOST_PARTS] _largest
    cdef Sums[MOST_PARTS] _sums
    cdef Descent[MOST_PARTS] _descents

    # Take the diagonal from the values, not under `floor`, and return the largest magnitude in
    # the gradient; NaN stays in the one and counts for nothing in the other.
    cdef double take_diagonal(self, double floor) noexcept nogil
    # Damp the diagonal by a multiple of itself, or of its largest value so far; the step becomes
    # the negative gradient.
    cdef void prepare(self, double damping, bint by_scale) noexcept nogil
    # Sums in f64 over all scalars.
    cdef Sums products(self) noexcept nogil
    # Keep the step as the Gauss-Newton step.
    cdef void keep_newton(self) noexcept nogil
    # Steepest descent in scaled variables; its sums.
    cdef Descent take_descent(self) noexcept nogil
    # The step becomes `along` times the descent plus `across` times the Gauss-Newton step.
    cdef void combine(self, double along, double across) noexcept nogil
    # Sum of g_i^2 / H_ii: the reduction that single coordinates promise, free of damping.
    cdef double scaled_gradient(self) noexcept nogil

    cdef void _share(self, Task task) noexcept nogil
    cdef Py_ssize_t _end(self, Py_ssize_t part) noexcept nogil
    cdef void _take_part(self, Py_ssize_t part, const real* values) noexcept nogil
    cdef void _prepare_part(self, Py_ssize_t part, const real* gradient) noexcept nogil
    cdef void _product_part(self, Py_ssize_t part, const real* step) noexcept nogil
    cdef void _descent_part(self, Py_ssize_t part, const real* gradient) noexcept nogil
    cdef void _combine_part(self, Py_ssize_t part, real* step) noexcept nogil
    cdef double _scaled(self, const real* gradient) noexcept nogil
