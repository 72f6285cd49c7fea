# The end by the factor of the linearisation before.


cdef class LastFactor(Attempt):
    cdef bint _ending                     # whether components end with what was just done
    cdef bint _asking                     # whether a component asks the last factor for its end
    cdef bint _exact                      # whether the solver keeps a factor

    cdef void _ask_factor(self) noexcept nogil
    cdef void _correct(self) noexcept nogil
