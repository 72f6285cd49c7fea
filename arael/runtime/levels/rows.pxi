"""Rows of a system: residuals and a sparse Jacobian, evaluated at flat unknowns."""

import numpy as np

from arael.runtime.address cimport address, writable
from libc.math cimport INFINITY, fabs, isfinite
from libc.stdint cimport int32_t


cdef class Rows:
    """Residual rows r(x) and their sparse Jacobian; abstract.

    Subclasses set `n`, `m`, the pattern, and the two functions of `rows.pxd`. From Python a system
    can be evaluated with `evaluate` and `jacobian`.

    Attributes
    ----------
    n, m : int
        Numbers of unknowns and of rows.
    pattern_version : int
        Changes whenever the pattern of the Jacobian does.
    """

    def __init__(self):
        if type(self) is Rows:
            raise TypeError("Rows is abstract; use PythonRows or the rows of a compiled model")

    cdef int residuals(self, const double* x, double* r) noexcept nogil:
        return -1

    cdef int linearise(self, const double* x, double* r, double* entries) noexcept nogil:
        return -1

    @property
    def indptr(self):
        """(m + 1,) int32, a copy: where the unknowns of each row begin in `indices`."""
        found = np.zeros(self.m + 1, dtype=np.int32)
        cdef int32_t* to = <int32_t*>writable(found, np.int32)
        cdef Py_ssize_t i
        if self.indptr != NULL:
            for i in range(self.m + 1):
                to[i] = self.indptr[i]
        return found

    @property
    def indices(self):
        """Unknowns of the rows, one row after the other: int32, a copy."""
        cdef Py_ssize_t i, count = self.indptr[self.m] if self.indptr != NULL else 0
        found = np.zeros(count, dtype=np.int32)
        cdef int32_t* to = <int32_t*>writable(found, np.int32)
        for i in range(count):
            to[i] = self.indices[i]
        return found

    def evaluate(self, x):
        """Residuals (m,) at the unknowns `x` (n,); entries that are not finite stay as they are."""
        x = np.ascontiguousarray(x, dtype=np.float64)
        r = np.zeros(self.m)
        cdef const double* at = <const double*>address(x, np.float64, self.n)
        cdef double* to = <double*>writable(r, np.float64, self.m)
        cdef int code
        with nogil:
            code = self.residuals(at, to)
        self.check(code)
        return r

    def holds(self, x, tolerance):
        """Whether no residual at the unknowns `x` (n,) is larger than its `tolerance` (m,)."""
        x = np.ascontiguousarray(x, dtype=np.float64)
        tolerance = np.ascontiguousarray(tolerance, dtype=np.float64)
        r = np.zeros(self.m)
        cdef const double* at = <const double*>address(x, np.float64, self.n)
        cdef const double* most = <const double*>address(tolerance, np.float64, self.m)
        cdef double* to = <double*>writable(r, np.float64, self.m)
        cdef int code
        cdef Py_ssize_t i
        cdef bint found = True
        with nogil:
            code = self.residuals(at, to)
            for i in range(self.m):
                if not fabs(to[i]) <= most[i]:
                    found = False
                    break
        self.check(code)
        return found

    def worst(self, x, tolerance):
        """The row whose residual at `x` (n,) is the largest share of its `tolerance` (m,).

        A residual that is not finite is the largest. Without rows (-1, 0).

        Returns
        -------
        row : int
        residual, share : float
            Of that row; all rows hold where the share is at most 1.
        """
        x = np.ascontiguousarray(x, dtype=np.float64)
        tolerance = np.ascontiguousarray(tolerance, dtype=np.float64)
        r = np.zeros(self.m)
        cdef const double* at = <const double*>address(x, np.float64, self.n)
        cdef const double* most = <const double*>address(tolerance, np.float64, self.m)
        cdef double* to = <double*>writable(r, np.float64, self.m)
        cdef int code = 0
        cdef Py_ssize_t i, row = -1
        cdef double share = -1.0
        if self.m == 0:
            return -1, 0.0, 0.0
        with nogil:
            code = self.residuals(at, to)
            for i in range(self.m):
                if not isfinite(to[i]):
                    row, share = i, INFINITY
                    break
                if fabs(to[i]) / most[i] > share:
                    row, share = i, fabs(to[i]) / most[i]
        self.check(code)
        return row, to[row], share

    def jacobian(self, x):
        """Residuals (m,), and entries of the Jacobian in the order of `indices`, at `x` (n,)."""
        x = np.ascontiguousarray(x, dtype=np.float64)
        r, entries = np.zeros(self.m), np.zeros(self.indptr[self.m] if self.indptr != NULL else 0)
        cdef const double* at = <const double*>address(x, np.float64, self.n)
        cdef double* to = <double*>writable(r, np.float64, self.m)
        cdef double* into = <double*>writable(entries, np.float64)
        cdef int code
        with nogil:
            code = self.linearise(at, to, into)
        self.check(code)
        return r, entries

    def check(self, int code):
        """Raise what a row written in Python raised."""
        if code < 0 and self.raised is not None:
            raised, self.raised = self.raised, None
            raise raised


cdef class PythonRows(Rows):
    """Rows from Python functions, for tests and small systems.

    Parameters
    ----------
    function : callable
        ``function(x)`` returns the residuals, (m,).
    jacobian : callable, optional
        ``jacobian(x)`` returns the Jacobian as a matrix (m, n), or only its entries in the order
        of the pattern; without it, central differences are taken.
    n, m : int
        Numbers of unknowns and of rows.
    pattern : sequence of sequences of int, or (m, n) bool, optional
        The unknowns of each row; all of them if absent.

    Raises
    ------
    ValueError
        If the pattern does not fit, or a function returns another number of values.
    """

    cdef object _function, _jacobian, _indptr, _indices, _row_of

    def __init__(self, function, jacobian=None, *, n, m, pattern=None):
        self.n, self.m = n, m
        self._function, self._jacobian = function, jacobian
        self.set_pattern(pattern)

    def set_pattern(self, pattern=None):
        """Replace the pattern; as in the constructor."""
        if pattern is None:
            lists = [range(self.n)] * self.m
        elif isinstance(pattern, np.ndarray) and pattern.ndim == 2:
            lists = [np.flatnonzero(row) for row in pattern]
        else:
            lists = [list(row) for row in pattern]
        if len(lists) != self.m:
            raise ValueError(f"expected the unknowns of {self.m} rows, found {len(lists)}")
        counts = [len(row) for row in lists]
        self._indptr = np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)
        self._indices = np.array([k for row in lists for k in row], dtype=np.int32)
        if len(self._indices) and not (
            0 <= self._indices.min() and self._indices.max() < self.n
        ):
            raise ValueError(f"expected unknowns from 0 to {self.n - 1} in the pattern")
        if any(len(set(row)) != len(row) for row in lists):
            raise ValueError("expected no unknown twice in a row of the pattern")
        self._row_of = np.repeat(np.arange(self.m), counts)
        self.indptr = <const int32_t*>address(self._indptr, np.int32)
        self.indices = <const int32_t*>address(self._indices, np.int32)
        self.pattern_version += 1

    def _residuals(self, x):
        r = np.asarray(self._function(x), dtype=np.float64).ravel()
        if len(r) != self.m:
            raise ValueError(f"expected {self.m} residuals, found {len(r)}")
        return r

    def _entries(self, x):
        if self._jacobian is None:
            matrix = np.empty((self.m, self.n))
            for k in range(self.n):
                h = 6e-6 * max(1.0, abs(x[k]))
                up, down = x.copy(), x.copy()
                up[k] += h
                down[k] -= h
                matrix[:, k] = (self._residuals(up) - self._residuals(down)) / (up[k] - down[k])
        else:
            matrix = np.asarray(self._jacobian(x), dtype=np.float64)
        if matrix.shape == (self.m, self.n):
            return matrix[self._row_of, self._indices]
        if matrix.shape != self._indices.shape:
            raise ValueError(
                f"expected a Jacobian of shape {(self.m, self.n)} or {self._indices.shape}, "
                f"found {matrix.shape}"
            )
        return matrix

    cdef int residuals(self, const double* x, double* r) noexcept nogil:
        with gil:
            return self._evaluate(x, r, NULL)

    cdef int linearise(self, const double* x, double* r, double* entries) noexcept nogil:
        with gil:
            return self._evaluate(x, r, entries)

    cdef int _evaluate(self, const double* x, double* r, double* entries) noexcept:
        """What both functions do, with the GIL."""
        cdef Py_ssize_t i, k
        cdef const double* found
        cdef int code = 0
        cdef double* into
        try:
            at = np.empty(self.n)
            into = <double*>writable(at, np.float64)
            for i in range(self.n):
                into[i] = x[i]
            values = np.ascontiguousarray(self._residuals(at))
            found = <const double*>address(values, np.float64, self.m)
            for i in range(self.m):
                r[i] = found[i]
                if not isfinite(r[i]) and code == 0:
                    code = <int>i + 1
            if entries == NULL:
                return code
            values = np.ascontiguousarray(self._entries(at))
            found = <const double*>address(values, np.float64, self.indptr[self.m])
            for i in range(self.m):
                for k in range(self.indptr[i], self.indptr[i + 1]):
                    entries[k] = found[k]
                    if not isfinite(found[k]) and (code == 0 or code > i + 1):
                        code = <int>i + 1
            return code
        except BaseException as problem:
            self.raised = problem
            return -1
