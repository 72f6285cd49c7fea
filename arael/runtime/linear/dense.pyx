# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
"""Dense Cholesky: own loops for a handful of unknowns, LAPACK beyond."""

import numpy as np

from libc.math cimport isfinite, sqrt
from libc.string cimport memset

from arael.runtime.linear cimport blas
from arael.runtime.linear.base cimport LinearSolver
from arael.runtime.linear.blas cimport real

from arael.runtime.linear.blas import load as load_blas

# Up to this size a call into LAPACK costs more than the factorisation.
cdef enum:
    SMALL = 16


cdef class DenseSolver(LinearSolver):
    """Cholesky factorisation of the whole matrix, O(n^3 / 3).

    Parameters
    ----------
    pattern : BlockPattern
    single : bool
        f32 if true, else f64.
    """

    cdef object _keep
    cdef void* _matrix              # (n, n) column-major, lower triangle
    cdef Py_ssize_t _blocks
    cdef const Py_ssize_t* _row       # first scalar row of each block
    cdef const Py_ssize_t* _column
    cdef const Py_ssize_t* _height
    cdef const Py_ssize_t* _width
    cdef const Py_ssize_t* _start

    def __init__(self, pattern, bint single=False):
        super().__init__(pattern, single)
        if self.n > SMALL:
            load_blas()
        block_column = np.repeat(np.arange(pattern.block_count), np.diff(pattern.column_start))
        parts = [
            pattern.offsets[pattern.rows],
            pattern.offsets[block_column],
            pattern.sizes[pattern.rows],
            pattern.sizes[block_column],
            pattern.value_start,
        ]
        index = np.ascontiguousarray(np.stack(parts), dtype=np.intp)
        matrix = np.zeros(max(self.n * self.n, 1), dtype=self.dtype)
        cdef Py_ssize_t[:, ::1] view = index
        cdef size_t address = matrix.ctypes.data
        self._keep = (index, matrix)
        self._matrix = <void*>address
        self._blocks = index.shape[1]
        if self._blocks:
            self._row, self._column = &view[0, 0], &view[1, 0]
            self._height, self._width, self._start = &view[2, 0], &view[3, 0], &view[4, 0]
        self.plan = {
            "solver": "dense",
            "n": self.n,
            "nnz_l": self.n * (self.n + 1) // 2,
            "flops": self.n**3 / 3,
        }

    cdef Py_ssize_t factor(self, const void* values, const void* diagonal) noexcept nogil:
        if self.single:
            return self._factor(<const float*>values, <const float*>diagonal)
        return self._factor(<const double*>values, <const double*>diagonal)

    cdef void solve(self, void* b) noexcept nogil:
        if self.n > SMALL:
            if self.single:
                blas.potrs(<int>self.n, <float*>self._matrix, <int>self.n, <float*>b)
            else:
                blas.potrs(<int>self.n, <double*>self._matrix, <int>self.n, <double*>b)
        elif self.single:
            solve_small(self.n, <float*>self._matrix, <float*>b)
        else:
            solve_small(self.n, <double*>self._matrix, <double*>b)

    cdef Py_ssize_t _factor(self, const real* values, const real* diagonal) noexcept nogil:
        cdef Py_ssize_t n = self.n, block, i, j, height, width, status
        cdef real* matrix = <real*>self._matrix
        cdef real* at
        cdef const real* value
        # The blocks need not cover the triangle, and what lies between them was overwritten.
        memset(matrix, 0, n * n * sizeof(real))
        for block in range(self._blocks):
            height, width = self._height[block], self._width[block]
            value = values + self._start[block]
            at = matrix + self._row[block] + self._column[block] * n
            if self._row[block] == self._column[block]:
                for i in range(height):
                    for j in range(i):
                        at[i + j * n] = value[i * width + j]
            else:
                for i in range(height):
                    for j in range(width):
                        at[i + j * n] = value[i * width + j]
        for i in range(n):
            matrix[i + i * n] = diagonal[i]
        if n <= SMALL:
            return factor_small(n, matrix)
        status = blas.potrf(<int>n, matrix, <int>n)
        # Optimised LAPACKs do not look for NaN; it then stands on the diagonal of the factor.
        for i in range(n if status == 0 else status - 1):
            if not isfinite(<double>matrix[i + i * n]):
                return i + 1
        return status


cdef Py_ssize_t factor_small(Py_ssize_t n, real* a) noexcept nogil:
    """Right-looking Cholesky in place, column-major with leading dimension n."""
    cdef Py_ssize_t i, j, k
    cdef real pivot, scale
    for k in range(n):
        pivot = a[k + k * n]
        # Written so that NaN fails too.
        if not (pivot > 0 and isfinite(<double>pivot)):
            return k + 1
        pivot = <real>sqrt(<double>pivot)
        a[k + k * n] = pivot
        scale = 1 / pivot
        for i in range(k + 1, n):
            a[i + k * n] *= scale
        for j in range(k + 1, n):
            scale = a[j + k * n]
            for i in range(j, n):
                a[i + j * n] -= a[i + k * n] * scale
    return 0


cdef void solve_small(Py_ssize_t n, const real* a, real* b) noexcept nogil:
    """Forward and backward substitution with the factor of `factor_small`."""
    cdef Py_ssize_t i, k
    cdef real x
    for k in range(n):
        x = b[k] / a[k + k * n]
        b[k] = x
        for i in range(k + 1, n):
            b[i] -= a[i + k * n] * x
    for k in range(n - 1, -1, -1):
        x = b[k]
        for i in range(k + 1, n):
            x -= a[i + k * n] * b[i]
        b[k] = x / a[k + k * n]
