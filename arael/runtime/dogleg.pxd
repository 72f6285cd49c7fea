# Powell's dogleg: the path from steepest descent to the Gauss-Newton step, cut at a trust region.

from arael.runtime.box cimport Box
from arael.runtime.vectors cimport Vectors


cdef class Dogleg:
    cdef readonly double radius  # of the trust region, in scaled variables; 0: not chosen yet
    cdef readonly double regularisation  # multiple of the scale that is added to the diagonal
    cdef readonly bint known            # whether this linearisation has its Gauss-Newton step
    cdef readonly double floor          # of the regularisation
    cdef double promise                 # reduction that the linearisation promises: -g' n
    cdef double length                  # of the proposed step, in scaled variables

    cdef Vectors _vectors
    cdef Box _box
    cdef double added                   # of that, by what was added to the diagonal
    cdef double _newton_length
    cdef bint _descended                # whether steepest descent is there
    cdef double _descent_length, _descent_curvature, _descent_added

    # A new linearisation.
    cdef void begin(self) noexcept nogil
    # Diagonal and right-hand side of the Gauss-Newton step.
    cdef void prepare(self) noexcept nogil
    # The matrix was not positive definite.
    cdef void regularise(self) noexcept nogil
    # The step in `vectors` is the Gauss-Newton step; `size` is the length of the state.
    cdef void take_newton(self, double size) noexcept nogil
    # Put the step into `vectors`, inside region and bounds; the reduction that the model predicts.
    cdef double propose(self) noexcept nogil
    # Move the radius after a step of gain ratio `gain`.
    cdef void adapt(self, bint accepted, double gain) noexcept nogil

    cdef void _descend(self) noexcept nogil
