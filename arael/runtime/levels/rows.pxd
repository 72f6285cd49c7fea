# Residual rows of a system and their Jacobian, as the solver by levels takes them.

from libc.stdint cimport int32_t


cdef class Rows:
    cdef readonly Py_ssize_t n              # unknowns
    cdef readonly Py_ssize_t m              # rows
    # Pattern of the Jacobian in CSR: the unknowns of row i are indices[indptr[i]:indptr[i + 1]],
    # in any order, none of them twice; a row that is off has none. The subclass owns the memory.
    # Pointers, n and m may change only together with `pattern_version`, never during a solve.
    cdef const int32_t* indptr              # [m + 1]
    cdef const int32_t* indices             # [indptr[m]]
    cdef readonly Py_ssize_t pattern_version
    cdef object raised                      # exception of a row written in Python, or None

    # Residuals [m] at x [n]. Returns 0; 1 + the first row whose residual is not finite; or -1 if a
    # row written in Python raised, with the exception in `raised`. Rows that are off are zero.
    cdef int residuals(self, const double* x, double* r) noexcept nogil
    # Residuals, and the entries of the Jacobian in the order of `indices`; the same result, where
    # an entry that is not finite counts like a residual.
    cdef int linearise(self, const double* x, double* r, double* entries) noexcept nogil
