"""The common interface of the linear solvers, and its use from Python."""

import numpy as np

from arael.runtime.address cimport address, writable
from arael.runtime.parallel.compiled cimport Kept


cdef class LinearSolver:
    """Base of the linear solvers for symmetric positive definite block matrices.

    Parameters
    ----------
    pattern : BlockPattern
        Lower block triangle of the matrix.
    single : bool
        f32 if true, else f64.
    """

    def __init__(self, pattern, bint single=False):
        self.pattern = pattern
        self.single = single
        self.n = pattern.size
        self.threads = 1
        self.raised = Kept()
        self.plan = {}

    cdef Py_ssize_t factor(self, const void* values, const void* diagonal) noexcept nogil:
        return 1

    cdef void solve(self, void* b) noexcept nogil:
        pass

    cdef Py_ssize_t factor_with(
        self, const void* values, const void* diagonal, const void* b
    ) noexcept nogil:
        return self.factor(values, diagonal)

    cdef void finish(self, void* b) noexcept nogil:
        self.solve(b)

    def restart(self):
        """Reset values adapted during an earlier solve; the symbolic analysis is kept."""

    def use_threads(self, int threads):
        """Set the number of threads of `factor` and `solve`.

        Results do not depend on the number, unless a solver documents it.
        """
        self.threads = threads

    @property
    def dtype(self):
        """NumPy type of the scalars."""
        return np.dtype(np.float32 if self.single else np.float64)

    def report(self):
        """Return the plan with results of the solves."""
        return dict(self.plan)

    def factorise(self, values, diagonal):
        """Factorise; return 0 or 1 + the scalar whose pivot failed.

        Parameters
        ----------
        values : (value_count,) array
        diagonal : (n,) array
            Damped diagonal that replaces the one in `values`.
        """
        v, d = self._system(values, diagonal)
        cdef const void* pv = address(v, v.dtype)
        cdef const void* pd = address(d, d.dtype)
        cdef Py_ssize_t status
        with nogil:
            status = self.factor(pv, pd)
        self.raised.again()
        return status

    def step(self, values, diagonal, b):
        """Factorise and solve together, like a Levenberg-Marquardt step.

        Parameters
        ----------
        values, diagonal : as for `factorise`
        b : (n,) array

        Returns
        -------
        status : int
            As of `factorise`.
        x : (n,) array, or None
            The solution, if the status is 0.
        """
        v, d = self._system(values, diagonal)
        x = np.array(b, dtype=self.dtype, ndmin=1)
        if x.shape != (self.n,):
            raise ValueError(f"expected a right-hand side of {self.n} rows, found shape {x.shape}")
        cdef const void* pv = address(v, v.dtype)
        cdef const void* pd = address(d, d.dtype)
        cdef void* px = writable(x, x.dtype)
        cdef Py_ssize_t status
        with nogil:
            status = self.factor_with(pv, pd, px)
            if status == 0:
                self.finish(px)
        self.raised.again()
        return status, x if status == 0 else None

    def _system(self, values, diagonal):
        v = np.ascontiguousarray(values, dtype=self.dtype)
        d = np.ascontiguousarray(diagonal, dtype=self.dtype)
        if v.shape != (self.pattern.value_count,) or d.shape != (self.n,):
            raise ValueError(
                f"expected {self.pattern.value_count} values and {self.n} diagonal entries, "
                f"found shapes {v.shape} and {d.shape}"
            )
        return v, d

    def solved(self, b):
        """Solution of the factorised system for the right-hand side `b`, shape (n,) or (n, k)."""
        cdef char* p
        cdef Py_ssize_t _
        rhs = np.array(b, dtype=self.dtype, order="F", ndmin=1)
        if rhs.shape[0] != self.n or rhs.ndim > 2:
            raise ValueError(
                f"expected a right-hand side of {self.n} rows, found shape {rhs.shape}"
            )
        if not rhs.size:
            return rhs
        # Columns lie one after another: each is solved in its place.
        p = <char*>writable(rhs.T, rhs.dtype)
        for _ in range(rhs.size // self.n):
            with nogil:
                self.solve(p)
            self.raised.again()
            p += self.n * rhs.itemsize
        return rhs
