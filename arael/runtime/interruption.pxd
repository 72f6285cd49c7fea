# A flag that any thread sets, and loops without the GIL read.

cimport cython


@cython.final
cdef class Interruption:
    cdef volatile int raised    # written by any thread, read between steps
    cdef long long looks        # until it is raised by itself; 0: never

    # Whether to break off, read between steps; the only thing that counts `looks`.
    cdef inline bint look(self) noexcept nogil:
        if self.looks > 0:
            self.looks -= 1
            if self.looks == 0:
                self.raised = 1
        return self.raised
