# cython: language_level=3
"""What Python code raised while a loop ran that cannot raise: kept until it can be."""

from libc.math cimport NAN

from arael.runtime.evaluation.natives cimport NativeTable


cdef class Kept:
    """The first exception that code without a way to raise met."""

    cdef double keep(self, error) noexcept:
        if not self.any:
            self.any = True
            self.error = error
        return NAN

    def again(self):
        """Raise what was kept, if anything, and forget it."""
        if self.any:
            error, self.error, self.any = self.error, None, False
            raise error


cdef class Raised(Kept):
    """The first exception of the interpreter or of a native function in Python.

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
