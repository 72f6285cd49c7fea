# The vectors of one solve, and what the Levenberg-Marquardt loop does with them.

from libc.stdint cimport int64_t

from arael.runtime.pool cimport Task

ctypedef fused real:
    float
    double

cdef enum:
    MOST_PARTS = 16


# Three sums over one part of the scalars.
cdef struct Sums:
    double slope                # g' step
    double length               # step' step
    double added                # step' (damped - own) step


cdef class Vectors:
    cdef readonly bint single   # f32 if true, else f64
    cdef readonly Py_ssize_t n
    cdef readonly int threads   # that share the passes
    # J'r and the values of J'J, each with what lies behind it; the diagonal, not under its floor;
    # that and its damping; the step.
    cdef readonly object gradient_array, value_array, diagonal_array, damped_array, step_array
    cdef void* gradient
    cdef void* values
    cdef void* step
    cdef void* damped
    cdef void* _diagonal
    cdef void* _own             # the diagonal as it is in the values
    cdef object _keep
    cdef const int64_t* _at     # [n] offsets of the diagonal in the values
    cdef Py_ssize_t _parts
    cdef double _floor
    cdef double _factor
    cdef double[MOST_PARTS] _largest
    cdef Sums[MOST_PARTS] _sums

    # Take the diagonal from the values, not under `floor`, and return the largest magnitude in
    # the gradient; NaN stays in the one and counts for nothing in the other.
    cdef double take_diagonal(self, double floor) noexcept nogil
    # Damp the diagonal; the step becomes the negative gradient.
    cdef void prepare(self, double damping) noexcept nogil
    # Sums in f64 over all scalars.
    cdef Sums products(self) noexcept nogil
    # Sum of g_i^2 / H_ii: the reduction that single coordinates promise, free of damping.
    cdef double scaled_gradient(self) noexcept nogil

    cdef void _share(self, Task task) noexcept nogil
    cdef Py_ssize_t _end(self, Py_ssize_t part) noexcept nogil
    cdef void _take_part(self, Py_ssize_t part, const real* values) noexcept nogil
    cdef void _prepare_part(self, Py_ssize_t part, const real* gradient) noexcept nogil
    cdef void _product_part(self, Py_ssize_t part, const real* step) noexcept nogil
    cdef double _scaled(self, const real* gradient) noexcept nogil
