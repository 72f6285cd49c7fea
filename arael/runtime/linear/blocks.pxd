# Copying the row-major blocks of a matrix to column-major places.


cdef void put(
    const long long* blocks, Py_ssize_t begin, Py_ssize_t end, const real* values, real* storage
) noexcept nogil
