"""Dense Cholesky: own kernels, or LAPACK for large matrices on processors with narrow vectors."""

from libc.math cimport isfinite
from libc.string cimport memset

from arael.runtime.address cimport table_address, writable
from arael.runtime.linear.lead cimport led

from arael.runtime.compiled import aligned_parts


cdef class DenseSolver(LinearSolver):
    """Cholesky factorisation of the whole matrix, O(n^3 / 3).

    Parameters
    ----------
    pattern : BlockPattern
    single : bool
        f32 if true, else f64.
    """

    cdef object _keep
    cdef void* _matrix              # column-major, lower triangle
    cdef void* _inverse             # (n,) 1 / diagonal of the factor
    cdef Py_ssize_t _leading
    cdef bint _large                # whether LAPACK is faster
    cdef Py_ssize_t _count
    cdef const long long* _blocks

    def __init__(self, pattern, bint single=False):
        super().__init__(pattern, single)
        self._large = self.n > large
        if self._large:
            load_blas()
        dtype = self.dtype
        self._leading = led(self.n, PAD_BYTES // dtype.itemsize)
        # A factorisation writes both before it reads them.
        matrix, inverse = aligned_parts((self.n * self._leading, self.n), dtype)
        table = block_table(pattern, self._leading)
        self._keep = (matrix, inverse, table)
        self._matrix, self._inverse = writable(matrix, dtype), writable(inverse, dtype)
        self._blocks = <const long long*>table_address(table, 4)
        self._count = len(table)
        self.plan = {
            "solver": "dense",
            "n": self.n,
            "nnz_l": self.n * (self.n + 1) // 2,
            "flops": float(self.n) ** 3 / 3,
        }

    cdef Py_ssize_t factor(self, const void* values, const void* diagonal) noexcept nogil:
        if self.single:
            return self._factor(<const float*>values, <const float*>diagonal)
        return self._factor(<const double*>values, <const double*>diagonal)

    cdef void solve(self, void* b) noexcept nogil:
        if self.single:
            self._solve(<float*>b)
        else:
            self._solve(<double*>b)

    cdef Py_ssize_t _factor(self, const real* values, const real* diagonal) noexcept nogil:
        cdef Py_ssize_t n = self.n, ld = self._leading, i, status
        cdef real* matrix = <real*>self._matrix
        # The blocks need not cover the triangle, and entries between them were overwritten.
        memset(matrix, 0, n * ld * sizeof(real))
        put(self._blocks, 0, self._count, values, matrix)
        for i in range(n):
            matrix[i + i * ld] = diagonal[i]
        if not self._large:
            if is_shared(self.threads, n):
                return factor_triangle(self.threads, n, matrix, ld, <real*>self._inverse)
            return tile_potrf(n, n, DENSE, matrix, ld, <real*>self._inverse)
        status = blas_potrf(<int>n, matrix, <int>ld)
        # Optimised LAPACKs do not check for NaN, which then is on the diagonal of the factor.
        for i in range(n if status == 0 else status - 1):
            if not isfinite(<double>matrix[i + i * ld]):
                return i + 1
        return status

    cdef void _solve(self, real* b) noexcept nogil:
        cdef Py_ssize_t n = self.n, ld = self._leading
        if self._large:
            blas_potrs(<int>n, <real*>self._matrix, <int>ld, b)
            return
        tile_forward(n, n, <const real*>self._matrix, ld, <const real*>self._inverse, b)
        tile_backward(n, n, <const real*>self._matrix, ld, <const real*>self._inverse, b)
