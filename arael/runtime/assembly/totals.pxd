# The arrays of J'r and J'J, with what lies behind them: trash, and places of the shares' own.

from cython cimport floating
from libc.stdint cimport int64_t


cdef class Totals:
    cdef readonly bint single              # f32 if true, else f64
    cdef readonly Py_ssize_t gradient_extent  # scalars of J'r with all that lies behind it
    cdef readonly Py_ssize_t value_extent     # the same of the values of J'J
    cdef const int64_t* diagonal_at         # [size] offsets of the diagonal in the values
    cdef object _keep                       # arrays that the pointers point into
    cdef object _arrays                     # of the solves, once one was there
    cdef const int64_t* _gradient_sums      # (m, 3), see `Shares`
    cdef const int64_t* _value_sums
    cdef const int64_t* _gradient_ends      # [shares + 1] rows of the sums that one thread takes
    cdef const int64_t* _value_ends
    cdef const int64_t* _cleared            # (m, 2) begin and end of values, see `Shares`
    cdef const int64_t* _cleared_ends       # [shares + 1] rows that one part is
    cdef const int64_t* _some               # (m, 2) what is zeroed of J'r; NULL: all of it
    cdef Py_ssize_t _some_count
    cdef object _all                        # arrays of the whole, and those that are in use
    cdef object _chosen
    cdef const int64_t* _held               # scalars of the system that do not move
    cdef Py_ssize_t _held_count
    cdef const int64_t* _held_values        # their rows and columns in the values
    cdef Py_ssize_t _held_value_count

    # Zero one of the shares' parts of both arrays, but for values that are stored first.
    cdef void clear(
        self, Py_ssize_t part, Py_ssize_t parts, void* gradient, void* values) noexcept nogil
    # Add what shares have in places of their own to where it belongs, and empty those: one part.
    cdef void add(self, Py_ssize_t share, void* gradient, void* values) noexcept nogil
    # Scalars that do not move get an identity row and no gradient.
    cdef void hold(self, void* gradient, void* values) noexcept nogil
    # NumPy's views of both arrays.
    cdef views(self, void* gradient, void* values)

    cdef const int64_t* _kept(self, array) except? NULL
    cdef void _hold(self, floating* gradient, floating* values) noexcept nogil
