"""What Python code raised while a loop ran that cannot raise: kept until it can be."""

from libc.math cimport NAN


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
