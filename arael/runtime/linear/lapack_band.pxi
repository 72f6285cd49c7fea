"""Banded Cholesky by LAPACK's pbtrf, for comparison with `band` and for very wide bands."""

from libc.math cimport isfinite
from libc.string cimport memset

from arael.runtime.address cimport table_address, writable

from arael.runtime.compiled import aligned_zeros
from arael.runtime.linear import bandwidth


cdef class LapackBandSolver(LinearSolver):
    """Cholesky factorisation of a banded matrix by LAPACK.

    Parameters and errors are those of `BandSolver`.
    """

    cdef object _keep
    cdef void* _matrix              # (kd + 1, n), LAPACK's lower band storage
    cdef Py_ssize_t _width          # kd
    cdef Py_ssize_t _bytes
    cdef Py_ssize_t _count
    cdef const long long* _blocks

    def __init__(self, pattern, bint single=False, half_bandwidth=None, block_half_bandwidth=None):
        super().__init__(pattern, single)
        load_blas()
        # LAPACK requires a band that fits into the matrix.
        kd = bandwidth.half_bandwidth(pattern, half_bandwidth, block_half_bandwidth)
        kd = min(kd, max(self.n - 1, 0))
        matrix = aligned_zeros((kd + 1) * self.n, self.dtype)
        # Entry (i, j) is at i - j + j (kd + 1): a full matrix of leading dimension kd.
        table = block_table(pattern, kd)
        self._keep = (matrix, table)
        self._matrix = writable(matrix, self.dtype)
        self._blocks = <const long long*>table_address(table, 4)
        self._width, self._bytes, self._count = kd, matrix.nbytes, len(table)
        self.plan = {
            "solver": "lapack_band",
            "n": self.n,
            "half_bandwidth": kd,
            "nnz_l": self.n * (kd + 1),
            "flops": bandwidth.band_flops(self.n, kd),
        }

    cdef Py_ssize_t factor(self, const void* values, const void* diagonal) noexcept nogil:
        if self.single:
            return self._factor(<const float*>values, <const float*>diagonal)
        return self._factor(<const double*>values, <const double*>diagonal)

    cdef void solve(self, void* b) noexcept nogil:
        cdef int n = <int>self.n, kd = <int>self._width
        if n == 0:
            return
        if self.single:
            blas_pbtrs(n, kd, <float*>self._matrix, kd + 1, <float*>b)
        else:
            blas_pbtrs(n, kd, <double*>self._matrix, kd + 1, <double*>b)

    cdef Py_ssize_t _factor(self, const real* values, const real* diagonal) noexcept nogil:
        cdef Py_ssize_t i, n = self.n, kd = self._width, status
        cdef real* matrix = <real*>self._matrix
        if n == 0:
            return 0
        memset(matrix, 0, self._bytes)
        put(self._blocks, 0, self._count, values, matrix)
        for i in range(n):
            matrix[i * (kd + 1)] = diagonal[i]
        status = blas_pbtrf(<int>n, <int>kd, matrix, <int>kd + 1)
        # Optimised LAPACKs do not check for NaN, which then is on the diagonal of the factor.
        for i in range(n if status == 0 else status - 1):
            if not isfinite(<double>matrix[i * (kd + 1)]):
                return i + 1
        return status
