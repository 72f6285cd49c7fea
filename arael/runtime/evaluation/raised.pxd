# What Python code raised while a loop ran that cannot raise.

from arael.runtime.evaluation.natives cimport NativeTable


cdef class Kept:
    cdef readonly bint any               # whether there is something, readable without the GIL
    cdef readonly object error           # the first exception, else None

    # Keep an exception, if it is the first; NaN, for callers that have no value to return.
    cdef double keep(self, error) noexcept


cdef class Raised(Kept):
    cdef readonly NativeTable natives

    # `value`; what a native function raised meanwhile is kept.
    cdef double checked(self, double value) noexcept nogil
