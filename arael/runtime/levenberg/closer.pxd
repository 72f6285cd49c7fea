# What the present linearisation promises, found with the factor of the one before.

from arael.runtime.linear.compiled cimport LinearSolver


cdef class Closer:
    cdef object _keep
    cdef double* _residual      # [n]
    cdef double* _direction     # [n]
    cdef double* _product       # [n] of the matrix with the direction
    cdef double* _solution      # [n] the steps so far

    # g' H^-1 g, if it is found to be at most `most`; else a negative number. The step of `vectors`
    # is H_old^-1 g with the sign of a step, `promise` its g' H_old^-1 g; where the end is found, it
    # is that of the steps afterwards.
    cdef double promise(
        self, Vectors vectors, Box box, LinearSolver solver, double promise, double most
    ) noexcept nogil
