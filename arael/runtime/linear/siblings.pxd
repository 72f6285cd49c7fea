# Supernodes that join their siblings; see siblings.pxi.

from libc.stdint cimport int64_t

cdef joined_siblings(
    Py_ssize_t n,
    Py_ssize_t ns,
    const int64_t* begin,
    const int64_t* parent,
    row_start,
    rows,
    const int64_t* order,
    const int64_t* weights,
)
