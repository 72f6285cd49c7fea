# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
"""Banded Cholesky in the order the entities stand in, O(n kd^2): for trajectories and chains.

Entry (i, j) of the factor lies at ``i + j * ld``: a dense column-major matrix whose leading dimension
is barely more than the half-bandwidth. So the dense kernels work on it as they are, as long as the
rows a vector may overshoot are kept zero behind each column.
"""

import numpy as np

from libc.string cimport memset

from arael.runtime.linear cimport tiles
from arael.runtime.linear.base cimport LinearSolver
from arael.runtime.linear.blas cimport real

from arael.runtime.linear import bandwidth
from arael.runtime.linear.memory import aligned

# Entries above the diagonal that the kernels spoil; they lie at the far end of the column before.
cdef enum:
    SPOILT = 6


cdef class BandSolver(LinearSolver):
    """Cholesky factorisation of a banded matrix.

    Parameters
    ----------
    pattern : BlockPattern
    single : bool
        f32 if true, else f64.
    half_bandwidth : int, optional
        Scalars that a row may lie below a column; by default what the pattern needs.
    block_half_bandwidth : int, optional
        The same in entities: 1 for a chain.

    Raises
    ------
    AraelError
        E1020 where the pattern couples entities farther apart than declared.
    """

    cdef object _keep
    cdef void* _matrix
    cdef void* _inverse             # (n,) 1 / diagonal of the factor
    cdef Py_ssize_t _height         # rows of a column that may be non-zero, the diagonal included
    cdef Py_ssize_t _leading
    cdef Py_ssize_t _bytes
    cdef Py_ssize_t _blocks
    cdef const Py_ssize_t* _row     # first scalar row of each block
    cdef const Py_ssize_t* _column
    cdef const Py_ssize_t* _tall
    cdef const Py_ssize_t* _wide
    cdef const Py_ssize_t* _start

    def __init__(self, pattern, bint single=False, half_bandwidth=None, block_half_bandwidth=None):
        super().__init__(pattern, single)
        kd = bandwidth.half_bandwidth(pattern, half_bandwidth, block_half_bandwidth)
        itemsize = self.dtype.itemsize
        # Rows a tile may overshoot: three vectors, or as many as cover the band and six columns.
        lanes = tiles.PAD_BYTES // itemsize
        overshoot = min(3, -(-(kd + 6) // lanes)) * lanes
        self._height = kd + 1
        self._leading = kd + overshoot - 1 + SPOILT
        matrix = aligned((self.n + overshoot) * (self._leading + 1), self.dtype)
        inverse = aligned(self.n, self.dtype)
        block_column = np.repeat(np.arange(pattern.block_count), np.diff(pattern.column_start))
        parts = [
            pattern.offsets[pattern.rows],
            pattern.offsets[block_column],
            pattern.sizes[pattern.rows],
            pattern.sizes[block_column],
            pattern.value_start,
        ]
        index = np.ascontiguousarray(np.stack(parts), dtype=np.intp)
        cdef Py_ssize_t[:, ::1] view = index
        cdef size_t address = matrix.ctypes.data, second = inverse.ctypes.data
        self._keep = (index, matrix, inverse)
        self._matrix, self._inverse = <void*>address, <void*>second
        self._bytes = matrix.nbytes
        self._blocks = index.shape[1]
        if self._blocks:
            self._row, self._column = &view[0, 0], &view[1, 0]
            self._tall, self._wide, self._start = &view[2, 0], &view[3, 0], &view[4, 0]
        self.plan = {
            "solver": "band",
            "n": self.n,
            "half_bandwidth": kd,
            "nnz_l": self.n * (kd + 1),
            "flops": float(self.n) * (kd + 1) ** 2,
        }

    cdef Py_ssize_t factor(self, const void* values, const void* diagonal) noexcept nogil:
        if self.single:
            return self._factor(<const float*>values, <const float*>diagonal)
        return self._factor(<const double*>values, <const double*>diagonal)

    cdef void solve(self, void* b) noexcept nogil:
        cdef Py_ssize_t n = self.n, height = self._height, ld = self._leading
        if self.single:
            tiles.forward(n, height, <const float*>self._matrix, ld, <const float*>self._inverse,
                          <float*>b)
            tiles.backward(n, height, <const float*>self._matrix, ld, <const float*>self._inverse,
                           <float*>b)
        else:
            tiles.forward(n, height, <const double*>self._matrix, ld, <const double*>self._inverse,
                          <double*>b)
            tiles.backward(n, height, <const double*>self._matrix, ld, <const double*>self._inverse,
                           <double*>b)

    cdef Py_ssize_t _factor(self, const real* values, const real* diagonal) noexcept nogil:
        cdef Py_ssize_t block, i, j, tall, wide, ld = self._leading
        cdef real* matrix = <real*>self._matrix
        cdef real* at
        cdef const real* value
        memset(matrix, 0, self._bytes)
        for block in range(self._blocks):
            tall, wide = self._tall[block], self._wide[block]
            value = values + self._start[block]
            at = matrix + self._row[block] + self._column[block] * ld
            if self._row[block] == self._column[block]:
                for i in range(tall):
                    for j in range(i):
                        at[i + j * ld] = value[i * wide + j]
            else:
                for j in range(wide):
                    for i in range(tall):
                        at[i + j * ld] = value[i * wide + j]
        for i in range(self.n):
            matrix[i + i * ld] = diagonal[i]
        return tiles.potrf(self.n, self._height, ld - SPOILT, matrix, ld, <real*>self._inverse)
