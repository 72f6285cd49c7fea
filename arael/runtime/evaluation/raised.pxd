# What Python code raised while a loop ran that cannot raise.

from arael.runtime.machine.compiled cimport NativeTable
from arael.runtime.parallel.compiled cimport Kept


cdef class Raised(Kept):
    cdef readonly NativeTable natives

    # `value`; what a native function raised meanwhile is kept.
    cdef double checked(self, double value) noexcept nogil
