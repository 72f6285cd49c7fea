# Leading dimensions of matrices in the solvers' storage.

from libc.stdint cimport int64_t

cdef enum:
    TALL = 16       # cache lines of a column from which conflicts matter


cdef inline int64_t led(int64_t rows, int64_t pad) noexcept nogil:
    """Leading dimension for a matrix of `rows`: a multiple of `pad`, the scalars of a cache line.

    Columns an even number of cache lines apart map to few sets of a cache; for tall matrices an odd
    number is used.
    """
    cdef int64_t lines = (rows + pad - 1) // pad
    if lines > TALL and lines % 2 == 0:
        lines += 1
    return lines * pad
