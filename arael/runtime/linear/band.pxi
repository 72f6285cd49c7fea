"""Banded Cholesky in the order of the entities, O(n kd^2): for trajectories and chains.

Entry (i, j) of the factor lies at ``i + j * ld``: a dense column-major matrix whose leading
dimension is slightly larger than the half-bandwidth. The dense kernels apply to it unchanged, if
the rows that a vector may overshoot are zero after each column. It is also LAPACK's lower band
storage; LAPACK factorises bands that do not fit the caches.
"""

from libc.math cimport isfinite
from libc.string cimport memset

from arael.runtime.address cimport table_address, writable

from arael.runtime.compiled import aligned_parts
from arael.runtime.linear import bandwidth

# Entries above the diagonal that the kernels overwrite, at the end of the previous column.
cdef enum:
    SPOILT = 6
    WIDE_BAND = 1536                     # half-bandwidth above which LAPACK is faster


cdef class BandSolver(LinearSolver):
    """Cholesky factorisation of a banded matrix.

    Parameters
    ----------
    pattern : BlockPattern
    single : bool
        f32 if true, else f64.
    half_bandwidth : int, optional
        Maximum distance of a row below a column in scalars; by default that of the pattern.
    block_half_bandwidth : int, optional
        The same in entities: 1 for a chain.

    Raises
    ------
    AraelError
        E1020 if the pattern couples entities farther apart than declared.
    """

    cdef object _keep
    cdef void* _matrix
    cdef void* _inverse             # (n,) 1 / diagonal of the factor
    cdef Py_ssize_t _height         # rows of a column that may be non-zero, the diagonal included
    cdef Py_ssize_t _leading
    cdef Py_ssize_t _bytes
    cdef Py_ssize_t _count
    cdef const long long* _blocks

    def __init__(self, pattern, bint single=False, half_bandwidth=None, block_half_bandwidth=None):
        super().__init__(pattern, single)
        kd = bandwidth.half_bandwidth(pattern, half_bandwidth, block_half_bandwidth)
        dtype = self.dtype
        # Rows a tile may overshoot: three vectors, or as many as cover the band and six columns.
        lanes = PAD_BYTES // dtype.itemsize
        overshoot = min(3, -(-(kd + 6) // lanes)) * lanes
        if kd >= WIDE_BAND:
            load_blas()
        self._height = kd + 1
        self._leading = kd + overshoot - 1 + SPOILT
        # A factorisation writes both before it reads them.
        extent = (self.n + overshoot) * (self._leading + 1)
        matrix, inverse = aligned_parts((extent, self.n), dtype)
        table = block_table(pattern, self._leading)
        self._keep = (matrix, inverse, table)
        self._matrix, self._inverse = writable(matrix, dtype), writable(inverse, dtype)
        self._blocks = <const long long*>table_address(table, 4)
        self._bytes = matrix.nbytes
        self._count = len(table)
        self.plan = {
            "solver": "band",
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
        cdef Py_ssize_t n = self.n, height = self._height, ld = self._leading
        if self.single:
            tile_forward(n, height, <const float*>self._matrix, ld, <const float*>self._inverse,
                         <float*>b)
            tile_backward(n, height, <const float*>self._matrix, ld, <const float*>self._inverse,
                          <float*>b)
        else:
            tile_forward(n, height, <const double*>self._matrix, ld, <const double*>self._inverse,
                         <double*>b)
            tile_backward(n, height, <const double*>self._matrix, ld, <const double*>self._inverse,
                          <double*>b)

    cdef Py_ssize_t _factor(self, const real* values, const real* diagonal) noexcept nogil:
        cdef Py_ssize_t i, ld = self._leading
        cdef real* matrix = <real*>self._matrix
        memset(matrix, 0, self._bytes)
        put(self._blocks, 0, self._count, values, matrix)
        for i in range(self.n):
            matrix[i + i * ld] = diagonal[i]
        if self._height > WIDE_BAND:
            return self._factor_wide(matrix, <real*>self._inverse)
        return tile_potrf(self.n, self._height, ld - SPOILT, matrix, ld, <real*>self._inverse)

    cdef Py_ssize_t _factor_wide(self, real* matrix, real* inverse) noexcept nogil:
        cdef Py_ssize_t n = self.n, ld = self._leading, i
        cdef int width = <int>min(self._height - 1, n - 1)  # LAPACK needs a band within the matrix
        cdef Py_ssize_t status = blas_pbtrf(<int>n, width, matrix, <int>(ld + 1))
        # Optimised LAPACKs do not check for NaN, which then is on the diagonal of the factor.
        for i in range(n if status == 0 else status - 1):
            if not isfinite(<double>matrix[i + i * ld]):
                return i + 1
            inverse[i] = 1 / matrix[i + i * ld]
        return status
