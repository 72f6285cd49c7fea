# What Python code raised while a loop ran that cannot raise.

from arael.runtime.natives cimport NativeTable


cdef class Raised:
    cdef readonly bint any               # whether there is something, readable without the GIL
    cdef readonly object error           # the first exception, else None
    cdef readonly NativeTable natives

    # Keep an exception, if it is the first; NaN, for whoever has no value to give.
    cdef double keep(self, error) noexcept
    # `value`; what a native function raised meanwhile is kept.
    cdef double checked(self, double value) noexcept nogil
