# The loop of a solve: plain C state, so that an iteration touches no Python object.


cdef class Minimiser(LastFactor):
    cdef readonly double start_cost
    cdef readonly Py_ssize_t accepted
    cdef readonly double predicted_decrease  # by the last linearisations, least damped
    cdef readonly double gradient_norm       # sqrt of the sum of g_i^2 / H_ii
    cdef readonly double noise_floor         # of the cost, by rounding

    cdef bint _all_accepted               # whether no component stays where it was
    cdef double _reached                  # cost of the whole after the attempt

    cdef void _run(self) noexcept nogil
    cdef void _start_components(self) noexcept nogil
    cdef void _start_at_costs(self) noexcept nogil
    cdef void _linearise(self) noexcept nogil
    cdef void _take_updated_costs(self) noexcept nogil
    cdef void _begin_components(self) noexcept nogil
    cdef void _end_at_linearisation(self) noexcept nogil
    cdef void _attempt(self) noexcept nogil
    cdef void _conclude(self) noexcept nogil
    cdef void _judge(self) noexcept nogil
    cdef void _accept(self) noexcept nogil
    cdef void _measure_tried(self) noexcept nogil
    cdef void _finish(self) noexcept nogil
