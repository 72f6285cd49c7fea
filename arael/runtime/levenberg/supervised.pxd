# What a solve has to do with Python and the clock.

from arael.runtime.evaluation.compiled cimport Evaluation
from arael.runtime.linear.compiled cimport LinearSolver


cdef enum:
    FIRST_FACTOR = 0
    LINEARISE
    FACTOR
    SOLVE
    REFRESH
    COST
    PHASES


cdef class Supervised:
    cdef readonly Evaluation evaluation
    cdef readonly LinearSolver solver
    cdef readonly Py_ssize_t attempts     # of which there are records
    cdef int _status
    cdef object _watcher
    cdef object _failure                  # what Python raised meanwhile
    cdef History _history
    cdef Record _now                      # of the present attempt
    cdef double[6] _phases                # seconds
    cdef double _began, _mark, _last_check

    # Whether a signal is pending that ends the solve.
    cdef bint _interrupted(self) noexcept nogil
    cdef void _keep_record(self) noexcept nogil
    # End the solve if evaluation or linear solver raised.
    cdef void _take_failure(self) noexcept nogil
    cdef _show(self)
    # Count the time since the last lap to a phase.
    cdef void _lap(self, int phase) noexcept nogil
