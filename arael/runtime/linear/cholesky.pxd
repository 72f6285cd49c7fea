# Multithreaded dense Cholesky, bit-identical for any number of threads.


# Whether threads share the rows of a triangle: `factor_triangle` for it, `tile_potrf` for others.
# The first has 30 KB on the stack, nearly all that the smallest thread has.
cdef bint is_shared(int threads, Py_ssize_t k) noexcept nogil

# Cholesky factor of a dense column-major triangle in place, 1 / diagonal to `inverse`; 0 or 1 + the
# failing pivot.
cdef Py_ssize_t factor_triangle(
    int threads, Py_ssize_t k, real* l, Py_ssize_t ld, real* inverse) noexcept nogil

# x = x l^-T, x of shape (r, k).
cdef void divide_rows(
    int threads, Py_ssize_t r, Py_ssize_t k, const real* l, Py_ssize_t ld, const real* inverse,
    real* x, Py_ssize_t ldx) noexcept nogil

# The n first columns of the lower triangle of u = -x x', x of shape (r, k); entries above it are
# overwritten.
cdef void outer_product(
    int threads, Py_ssize_t r, Py_ssize_t n, Py_ssize_t k, const real* x, Py_ssize_t ldx, real* u,
    Py_ssize_t ldu) noexcept nogil
