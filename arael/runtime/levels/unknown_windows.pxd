# Unknowns and constants as kernels read them: as rows of entities at any offset.

from libc.stdint cimport int32_t

cdef enum:
    MOST_WIDTH = 8


cdef class UnknownWindows:
    cdef readonly Py_ssize_t n              # unknowns
    cdef readonly Py_ssize_t constants      # scalars of all blocks of constants, free ones included
    cdef Py_ssize_t _capacity               # of unknowns
    cdef Py_ssize_t _constant_capacity
    cdef dict _lengths                      # of the blocks in use, by offset
    cdef dict _spare                        # offsets of free blocks, by length
    cdef double* _memory[MOST_WIDTH + 1]    # by width, NULL where no entity has it

    cdef _windows(self, Py_ssize_t begin, Py_ssize_t end)
    cdef _grow(self, Py_ssize_t capacity, Py_ssize_t constants)
    # Row of an entity of so many scalars: at 0 the first unknowns, at -1 the last constant.
    cdef const double* of_width(self, Py_ssize_t width) noexcept nogil
    cdef void fill(self, const double* x) noexcept nogil
    cdef void put(self, Py_ssize_t at, double value) noexcept nogil
    cdef bint holds(self, Py_ssize_t offset, Py_ssize_t width) noexcept nogil
