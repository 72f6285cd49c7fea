# The face that every linear solver shows to the Levenberg-Marquardt loop.
#
# Matrices and vectors are `void*`: f64 or f32 as `single` tells, so that one virtual table serves
# both precisions and the loop above needs no fused types.

from arael.runtime.raised cimport Kept


cdef class LinearSolver:
    cdef readonly bint single       # f32 if true, else f64
    cdef readonly object pattern    # BlockPattern
    cdef readonly dict plan         # name, why, n, nnz_l, flops, ... of the symbolic analysis
    cdef readonly Py_ssize_t n      # scalars
    cdef readonly int threads       # that factor and solve may use; see `use_threads`
    cdef readonly Kept raised       # what Python code under factor or solve raised; see `factor`

    # Factorise H with its diagonal replaced by `diagonal` (n scalars, damping included).
    # `values` are the blocks as the pattern lays them out; neither argument is changed.
    # Returns 0, or 1 + the scalar (original order) at whose pivot the matrix was found not to be
    # positive definite (NaN included). Never raises, never allocates. A solver that calls Python
    # keeps what that raises in `raised`, and returns 1: not a rejection, the caller has to look.
    cdef Py_ssize_t factor(self, const void* values, const void* diagonal) noexcept nogil

    # Overwrite b (n scalars, original order) by the solution; needs a successful factor().
    cdef void solve(self, void* b) noexcept nogil

    # Both, where the right-hand side is there before the factor: a solver may take b along while
    # it factorises. After a successful factor_with(), and nothing else in between, finish()
    # overwrites b, the same and unchanged, by the solution.
    cdef Py_ssize_t factor_with(
        self, const void* values, const void* diagonal, const void* b) noexcept nogil
    cdef void finish(self, void* b) noexcept nogil
