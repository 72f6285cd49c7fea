"""CHOLMOD as one of the linear solvers, for comparison."""

import numpy as np

from libc.math cimport isfinite

from arael.runtime.address cimport address, writable

from arael.runtime.linear.cholmod_api import new_factor
from arael.runtime.linear.openmp import OpenMP


cdef class CholmodSolver(LinearSolver):
    """Sparse Cholesky by SuiteSparse; works in f64 for problems of either precision.

    Acquires the GIL inside `factor` and `solve`. Its own loops run on the calling thread; its BLAS
    uses the threads configured for BLAS.

    Parameters
    ----------
    pattern : BlockPattern
    single : bool
        Whether the problem is given in f32.

    Raises
    ------
    AraelError
        E0841 if scikit-sparse is missing.
    """

    cdef object _matrix             # lower triangle in CSC format, its data in _data
    cdef object _factor
    cdef object _openmp
    cdef object _keep
    cdef object _b
    cdef Py_ssize_t _count
    cdef double* _data
    cdef double* _right
    cdef const long long* _source   # value of each entry, or -1 - scalar for the diagonal
    cdef const int* _row            # row of each entry, for messages

    def __init__(self, pattern, bint single=False):
        # Imported here for start-up time: scipy.sparse takes a tenth of a second.
        from scipy.sparse import csc_matrix

        super().__init__(pattern, single)
        rows, columns, source = entries(pattern)
        start = np.searchsorted(columns, np.arange(self.n + 1)).astype(np.intc)
        rows = rows.astype(np.intc)
        data = np.where(source < 0, 1.0, 0.0)
        self._matrix = csc_matrix((data, rows, start), shape=(self.n, self.n))
        self._b = np.zeros(self.n)
        self._keep = (source, self._matrix.data, self._matrix.indices)
        self._count = len(source)
        self._source = <const long long*>address(source, np.int64)
        self._data = <double*>writable(self._matrix.data, np.float64, self._count)
        self._row = <const int*>address(self._matrix.indices, np.intc, self._count)
        self._right = <double*>writable(self._b, np.float64, self.n)
        self._factor = new_factor(self._matrix) if self.n else None
        self._openmp = OpenMP()     # CHOLMOD is loaded here
        self.plan = {"solver": "cholmod", "n": self.n}

    cdef Py_ssize_t factor(self, const void* values, const void* diagonal) noexcept nogil:
        cdef Py_ssize_t status
        if self.n == 0:
            return 0
        if self.single:
            status = self._fill(<const float*>values, <const float*>diagonal)
        else:
            status = self._fill(<const double*>values, <const double*>diagonal)
        if status:
            return status
        with gil:
            try:
                with self._openmp.on_one_thread():
                    return 1 + <Py_ssize_t>self._factor.factorise(self._matrix)
            except BaseException as failure:  # includes KeyboardInterrupt, which must end the solve
                self._keep_failure(failure)
                return 1

    cdef void solve(self, void* b) noexcept nogil:
        cdef Py_ssize_t i
        if self.n == 0:
            return
        for i in range(self.n):
            self._right[i] = (<float*>b)[i] if self.single else (<double*>b)[i]
        with gil:
            try:
                self._b[:] = self._factor.solve(self._b)
            except BaseException as failure:
                self._keep_failure(failure)
        for i in range(self.n):
            if self.single:
                (<float*>b)[i] = <float>self._right[i]
            else:
                (<double*>b)[i] = self._right[i]

    cdef _keep_failure(self, failure):
        if not isinstance(failure, KeyboardInterrupt):
            failure.add_note("raised by scikit-sparse, in the linear solver 'cholmod'")
        self.raised.keep(failure)

    cdef Py_ssize_t _fill(self, const real* values, const real* diagonal) noexcept nogil:
        """Copy the entries; CHOLMOD does not check for NaN, so 1 + its row is returned here."""
        cdef Py_ssize_t k
        cdef long long s
        cdef Py_ssize_t status = 0
        for k in range(self._count):
            s = self._source[k]
            self._data[k] = values[s] if s >= 0 else diagonal[-1 - s]
            if status == 0 and not isfinite(self._data[k]):
                status = 1 + self._row[k]
        return status


def entries(pattern):
    """Scalar entries of the lower triangle by columns.

    Returns
    -------
    rows, columns, source : (m,) int64
        Row and column of each entry, and its place among the values, or -1 - scalar for an entry of
        the diagonal.
    """
    block_column = np.repeat(np.arange(pattern.block_count), np.diff(pattern.column_start))
    height, width = pattern.sizes[pattern.rows], pattern.sizes[block_column]
    area = height * width
    block = np.repeat(np.arange(len(area)), area)
    local = np.arange(int(area.sum())) - np.repeat(np.cumsum(area) - area, area)
    offsets = pattern.offsets
    rows = offsets[pattern.rows[block]] + local // width[block]
    columns = offsets[block_column[block]] + local % width[block]
    source = np.where(rows == columns, -1 - rows, pattern.value_start[block] + local)
    lower = rows >= columns
    rows, columns, source = rows[lower], columns[lower], source[lower]
    order = np.lexsort((rows, columns))
    return rows[order], columns[order], np.ascontiguousarray(source[order], dtype=np.int64)
