"""Elimination of an independent set of entities, and another direct solver for the reduced
system."""

from arael.runtime.address cimport writable

from arael.runtime.compiled import aligned_zeros


cdef class SchurSolver(LinearSolver):
    """Cholesky factorisation that begins with many small uncoupled blocks.

    Parameters
    ----------
    pattern : BlockPattern
    single : bool
        f32 if true, else f64.
    reduction : Reduction
        Plan of the elimination.
    products : Products
        All blocks of the reduced system.
    inner : LinearSolver
        Solver for the reduced system's pattern, in the same precision.
    """

    cdef readonly LinearSolver inner
    cdef Elimination _elimination
    cdef Sums _sums
    cdef object _keep
    cdef void* _reduced             # right-hand side and solution of the reduced system

    def __init__(self, pattern, bint single, reduction, products, LinearSolver inner):
        super().__init__(pattern, single)
        self.inner = inner
        self._elimination = Elimination(reduction, self.dtype)
        self._sums = Sums(self._elimination, products, self.dtype)
        reduced = aligned_zeros(inner.n, self.dtype)
        self._keep = reduced
        self._reduced = writable(reduced, self.dtype)
        self.plan = {
            "solver": "schur",
            "n": self.n,
            "eliminated": int(reduction.eliminated.sum()),
            "reduced_n": inner.n,
            "reduced_solver": inner.plan["solver"],
            "products": len(products.pairs),
            "nnz_l": inner.plan["nnz_l"] + reduction.factor_size + reduction.stored_size,
        }

    @property
    def reduction(self):
        """What is eliminated, and how."""
        return self._elimination.reduction

    def use_threads(self, int threads):
        """Set the number of threads of the elimination and the inner solver."""
        self.threads = self._elimination.threads = threads
        self.inner.use_threads(threads)

    cdef Py_ssize_t factor(self, const void* values, const void* diagonal) noexcept nogil:
        cdef Py_ssize_t status
        if self.single:
            status = self._reduce(<const float*>values, <const float*>diagonal, NULL)
        else:
            status = self._reduce(<const double*>values, <const double*>diagonal, NULL)
        if status == 0:
            status = self._named(self.inner.factor(self._sums._values, self._sums._damped))
        return status

    cdef Py_ssize_t factor_with(
        self, const void* values, const void* diagonal, const void* b
    ) noexcept nogil:
        cdef Py_ssize_t status
        if self.single:
            status = self._reduce(<const float*>values, <const float*>diagonal, b)
        else:
            status = self._reduce(<const double*>values, <const double*>diagonal, b)
        if status:
            return status
        return self._named(
            self.inner.factor_with(self._sums._values, self._sums._damped, self._reduced))

    cdef void solve(self, void* b) noexcept nogil:
        self._descend(b)
        self.inner.solve(self._reduced)
        self._ascend(b)

    cdef void finish(self, void* b) noexcept nogil:
        self.inner.finish(self._reduced)
        self._ascend(b)

    cdef Py_ssize_t _named(self, Py_ssize_t status) noexcept nogil:
        """Status of the inner solver in scalars of the whole system."""
        return 1 + self._elimination._scalar[status - 1] if status else 0

    cdef void _descend(self, const void* b) noexcept nogil:
        if self.single:
            self._elimination.descend(<const float*>b, <float*>self._reduced)
        else:
            self._elimination.descend(<const double*>b, <double*>self._reduced)

    cdef void _ascend(self, void* b) noexcept nogil:
        if self.single:
            self._elimination.ascend(<const float*>self._reduced, <float*>b)
        else:
            self._elimination.ascend(<const double*>self._reduced, <double*>b)

    cdef Py_ssize_t _reduce(
        self, const real* values, const real* diagonal, const void* b
    ) noexcept nogil:
        """Form the reduced system, with its right-hand side if `b` is given."""
        cdef Py_ssize_t status
        if b == NULL:
            status = self._elimination.eliminate(values, diagonal)
        else:
            status = self._elimination.eliminate_with(
                values, diagonal, <const real*>b, <real*>self._reduced)
        if status == 0:
            self._sums.form(values, diagonal)
        return status
