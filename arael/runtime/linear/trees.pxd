# Passes over a graph in an order of elimination; see trees.pxi.

from libc.stdint cimport int64_t

cdef void find_positions(Py_ssize_t n, const int64_t* order, int64_t* at) noexcept nogil
cdef void find_parents(
    Py_ssize_t n,
    const int64_t* start,
    const int64_t* neighbours,
    const int64_t* order,
    const int64_t* at,
    int64_t* parent,
    int64_t* ancestor,
) noexcept nogil
cdef void find_postorder(
    Py_ssize_t n, const int64_t* parent, int64_t* out, int64_t* work
) noexcept nogil
cdef void find_counts(
    Py_ssize_t n,
    const int64_t* start,
    const int64_t* neighbours,
    const int64_t* order,
    const int64_t* at,
    const int64_t* parent,
    const int64_t* weight,
    int64_t* counts,
    int64_t* rows,
    int64_t* seen,
) noexcept nogil
