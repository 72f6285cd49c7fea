# The interface of linear solvers for the solver loop.
#
# Matrices and vectors are `void*`: f64 or f32 depending on `single`, so that one virtual table
# serves both precisions and the loop above needs no fused types.

from arael.runtime.parallel.compiled cimport Kept


cdef class LinearSolver:
    cdef readonly bint single       # f32 if true, else f64
    cdef readonly object pattern    # BlockPattern
    cdef readonly dict plan         # name, why, n, nnz_l, flops, ... of the symbolic analysis
    cdef readonly Py_ssize_t n      # scalars
    cdef readonly int threads       # for factor and solve; see `use_threads`
    cdef readonly Kept raised       # exceptions of Python code in factor or solve; see `factor`

    # Factorise H with its diagonal replaced by `diagonal` (n scalars, damping included). `values`
    # are the blocks in the layout of the pattern; neither argument is changed. Returns 0, or 1 +
    # the scalar (original order) at whose pivot the matrix was found not to be positive definite
    # (NaN included). Never raises, never allocates. A solver that calls Python stores an exception
    # in `raised` and returns 1; the caller must distinguish this from a rejection.
    cdef Py_ssize_t factor(self, const void* values, const void* diagonal) noexcept nogil

    # Overwrite b (n scalars, original order) by the solution; needs a successful factor().
    cdef void solve(self, void* b) noexcept nogil

    # Both, if the right-hand side is available before the factorisation: a solver may process b
    # while it factorises. Directly after a successful factor_with(), finish() overwrites the same,
    # unchanged b by the solution.
    cdef Py_ssize_t factor_with(
        self, const void* values, const void* diagonal, const void* b) noexcept nogil
    cdef void finish(self, void* b) noexcept nogil
