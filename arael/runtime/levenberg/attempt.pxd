# The parts of one attempt.

from arael.runtime.levenberg.component cimport Component


cdef class Attempt(Partitioned):
    # Of the whole system, failed ones counted, and their seconds but for the first.
    cdef readonly Py_ssize_t factorisations
    cdef readonly double factor_seconds
    cdef readonly double damping          # largest lambda of the next attempt
    cdef readonly Dogleg dogleg
    cdef readonly InnerSteps inner        # of damped steps, or None

    cdef object _separable                # what makes `inner` where the dogleg fails, or None
    cdef object _driver                   # the caller's function for custom damping, or None

    cdef bint _may_attempt(self) noexcept nogil
    cdef bint _factor(self) noexcept nogil
    cdef void _blame(self, Py_ssize_t pivot) noexcept nogil
    cdef void _propose_damped(self) noexcept nogil
    cdef void _look_ahead(self) noexcept nogil
    cdef void _iterate_inside(self) noexcept nogil
    cdef void _separate(self) noexcept nogil
    cdef void _next_damping(self, Component* c) noexcept nogil
    cdef void _ask_driver(self) noexcept nogil
