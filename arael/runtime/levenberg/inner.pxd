# Inner iterations: what is eliminated from the linear system is solved again at each trial state.

from libc.stdint cimport uint8_t

from arael.runtime.evaluation.compiled cimport ComponentLanes, Evaluation
from arael.runtime.linear.compiled cimport Entity

# Lengths of a step that are tried.
cdef enum:
    LENGTHS = 4


cdef class InnerSteps:
    cdef readonly Py_ssize_t count  # eliminated entities
    cdef ComponentLanes _lanes      # instances by the entity that they read
    cdef const Entity* _entities    # [count]
    cdef object _keep               # what the pointers point into
    cdef double _floor
    cdef void* _gradient            # of the trial state
    cdef void* _values
    cdef void* _base                # the step to the trial state
    cdef void* _own                 # Gauss-Newton steps of the entities from there
    cdef double* _promise           # [count] decreases that they predict
    cdef double* _before            # [count + 1] costs at the trial state
    cdef double* _after             # [LENGTHS][count + 1] costs after each length
    cdef double* _work              # a factor and a vector

    # Improve the trial state, which is the accepted state moved by the step of `vectors`, and
    # complete that step. Shorter lengths are tried where entities predict more than `least`
    # together without reaching it.
    cdef void improve(
        self, Evaluation evaluation, Vectors vectors, double least) noexcept nogil

    cdef void _costs(self, Evaluation evaluation, double* total) noexcept nogil
    cdef void _improve(
        self, Evaluation evaluation, Vectors vectors, real* step, double least) noexcept nogil
    cdef void _solve(self, const real* gradient, const real* values, real* own) noexcept nogil
    cdef double _own_step(
        self, const Entity* e, const real* gradient, const real* values, real* own) noexcept nogil
    cdef double _missed(self, const double* after) noexcept nogil
    cdef double _best_length(self, Py_ssize_t k, int tried) noexcept nogil
