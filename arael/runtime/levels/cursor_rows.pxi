"""Soft rows of a drag: unknowns at the places of a cursor."""

import numpy as np

from libc.stdint cimport int32_t, int64_t

from arael.runtime.address cimport address, writable


cdef class CursorRows(Rows):
    """Unknowns minus their targets: rows x[at] - target."""

    cdef object _at, _target, _indptr
    cdef const int32_t* at
    cdef double* target

    def __init__(self, n, at, target):
        self._at = np.array(at, dtype=np.int32).ravel()
        self._target = np.array(target, dtype=np.float64).ravel()
        if len(self._at) != len(self._target):
            raise ValueError(f"expected {len(self._at)} targets, found {len(self._target)}")
        if len(self._at) and not 0 <= self._at.min() <= self._at.max() < n:
            raise ValueError(f"expected unknowns from 0 to {n - 1} to drag")
        self.n, self.m = n, len(self._at)
        self._indptr = np.arange(self.m + 1, dtype=np.int32)
        self.indptr = <const int32_t*>address(self._indptr, np.int32)
        self.indices = self.at = <const int32_t*>address(self._at, np.int32)
        self.target = <double*>writable(self._target, np.float64)

    def aim(self, at, target):
        """Take other targets; False, and nothing else, where these are other unknowns.

        Parameters
        ----------
        at, target : arrays; only those of int64 and float64 are compared
        """
        for one, dtype in ((at, np.int64), (target, np.float64)):
            if not isinstance(one, np.ndarray) or one.dtype != dtype or one.shape != (self.m,):
                return False
        cdef const int64_t* unknowns = <const int64_t*>address(at, np.int64)
        cdef const double* places = <const double*>address(target, np.float64)
        cdef Py_ssize_t i
        for i in range(self.m):
            if unknowns[i] != self.at[i]:
                return False
        for i in range(self.m):
            self.target[i] = places[i]
        return True

    cdef int residuals(self, const double* x, double* r) noexcept nogil:
        cdef Py_ssize_t i
        for i in range(self.m):
            r[i] = x[self.at[i]] - self.target[i]
        return 0

    cdef int linearise(self, const double* x, double* r, double* entries) noexcept nogil:
        cdef Py_ssize_t i
        for i in range(self.m):
            entries[i] = 1.0
        return self.residuals(x, r)
