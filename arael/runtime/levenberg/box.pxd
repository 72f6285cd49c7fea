# Bounds of parameters: scalars held at a bound, and steps cut off at it.

from libc.stdint cimport int32_t, int64_t, uint8_t

from cython cimport floating

from arael.runtime.evaluation.compiled cimport Evaluation


cdef class Box:
    cdef readonly Py_ssize_t count          # bounded scalars
    cdef Evaluation _evaluation
    cdef object _all                        # arrays of the whole, and those that are in use
    cdef object _keep
    cdef const int64_t* _scalar             # [count] scalar of the system
    cdef const int64_t* _entity             # [count]
    cdef const int64_t* _at                 # [count] offset of the stored scalar in its state array
    cdef const int64_t* _diagonal           # [count] offset of the diagonal in the values
    cdef const double* _low
    cdef const double* _high
    cdef const int64_t* _start              # [count + 1] into _positions
    cdef const int64_t* _positions          # rows and columns in the values
    cdef Py_ssize_t _block_count
    cdef const int64_t* _blocks             # [blocks][5] row, column, height, width, start

    # Set the flags of components with bounded scalars, `stride` bytes from each to the next.
    cdef void mark(
        self, const int32_t* component, uint8_t* bounded, Py_ssize_t stride) noexcept nogil
    # Give scalars at a bound whose gradient points outward an identity row and no gradient.
    cdef void hold(self, void* gradient, void* values) noexcept nogil
    # Cut a step off at the bounds; whether it was cut. `cut` is set for components of which it was;
    # `component` is that of each scalar, or NULL: all are of one.
    cdef bint clamp(self, void* step, const int32_t* component, uint8_t* cut) noexcept nogil
    # Add step' H step by component, for steps that do not solve the damped system.
    cdef void curvature(
        self, const void* values, const void* step, const int32_t* component, double* total
    ) noexcept nogil
    # H x of the whole system.
    cdef void product(self, const void* values, const double* x, double* found) noexcept nogil

    cdef double _value(self, Py_ssize_t k) noexcept nogil
    cdef void _hold(self, floating* gradient, floating* values) noexcept nogil
    cdef bint _clamp(
        self, floating* step, const int32_t* component, uint8_t* cut) noexcept nogil
    cdef void _curvature(
        self, const floating* values, const floating* step, const int32_t* component,
        double* total) noexcept nogil
    cdef void _product(self, const floating* values, const double* x, double* found) noexcept nogil
