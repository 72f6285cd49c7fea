# Dense Cholesky on threads, in steps whose results do not depend on the number of threads.

from arael.runtime.linear.blas cimport real

cdef enum:
    BLOCKED = 192       # columns from which a triangle is factored by blocks

# Every row of a dense triangle may be addressed from every column.
cdef Py_ssize_t DENSE

# Cholesky factor of a dense column-major triangle in place, 1 / diagonal to `inverse`; 0 or 1 + the
# failing pivot. `ld` is a multiple of PAD_BYTES.
cdef Py_ssize_t factor_triangle(
    int threads, Py_ssize_t k, real* l, Py_ssize_t ld, real* inverse) noexcept nogil

# x = x l^-T, x of shape (r, k).
cdef void divide_rows(
    int threads, Py_ssize_t r, Py_ssize_t k, const real* l, Py_ssize_t ld, const real* inverse,
    real* x, Py_ssize_t ldx) noexcept nogil

# Lower triangle of u = -x x', x of shape (r, k); what lies above it is spoilt.
cdef void outer_product(
    int threads, Py_ssize_t r, Py_ssize_t k, const real* x, Py_ssize_t ldx, real* u, Py_ssize_t ldu
) noexcept nogil
