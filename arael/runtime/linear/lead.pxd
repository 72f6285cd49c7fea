# Leading dimensions of matrices in the solvers' storage, as `memory.leading` has them.

from libc.stdint cimport int64_t

cdef enum:
    TALL = 16       # cache lines of a column from which conflicts matter


cdef inline int64_t led(int64_t rows, int64_t pad) noexcept nogil:
    """As `memory.leading`."""
    cdef int64_t lines = (rows + pad - 1) // pad
    if lines > TALL and lines % 2 == 0:
        lines += 1
    return lines * pad
