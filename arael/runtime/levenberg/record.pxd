# The record of an attempt, and those of all attempts of a solve.

from libc.stdint cimport int32_t, int64_t


# One attempt at a step. The layout of `RECORD` in record.pxi.
ctypedef struct Record:
    int32_t iteration     # from 1; retries keep the number
    int32_t retry         # rejections before this attempt, with the same linearisation
    int32_t accepted      # of any component
    int32_t factored      # whether the damped matrix was positive definite
    int64_t pivot         # scalar at which factorisation failed, or -1
    double cost           # before
    double trial_cost     # after; NaN without a step
    double predicted      # reduction that the linear model predicts for the step
    double promise        # reduction that it predicts for the step without bounds and region
    double radius         # of the trust region; NaN where there is none
    double damping        # lambda in effect
    double next_damping   # lambda of the attempt to come
    double step_norm
    double gradient       # largest magnitude of the gradient 2 J'r
    double seconds        # spent on this attempt


cdef class History:
    cdef readonly Py_ssize_t count  # of records
    cdef object _array
    cdef Record* _records
    cdef Py_ssize_t _capacity

    # Keep a record; False if there is no place for one more.
    cdef bint keep(self, const Record* record) noexcept nogil
