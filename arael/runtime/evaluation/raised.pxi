"""What native functions and the interpreter raised while the GIL was released."""

from arael.runtime.machine.compiled cimport NativeTable
from arael.runtime.parallel.compiled cimport Kept


cdef class Raised(Kept):
    """The first exception of a native function in Python.

    Parameters
    ----------
    natives : NativeTable
        The native functions of the model.
    """

    def __init__(self, NativeTable natives):
        self.natives = natives

    cdef double checked(self, double value) noexcept nogil:
        if self.natives.failed:
            with gil:
                self.keep(self.natives.failure)
        return value

    def again(self):
        """Raise what was kept, if anything, and forget it."""
        if self.any:
            self.natives.clear()
            super().again()
