# Native functions as kernels call them.

from arael.runtime.kernel cimport Native


cdef class NativeTable:
    cdef Native* items           # one per native function of the layout
    cdef bint failed             # whether a Python function raised, readable without the GIL
    cdef readonly object failure  # what it raised, else None
    cdef readonly list names     # in order of `items`
    cdef readonly dict bindings  # by name, kept alive

    cdef double through_python(self, const Native* native, const double* x) noexcept
