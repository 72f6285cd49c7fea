# Powell's dogleg: the path from steepest descent to the Gauss-Newton step, cut at a trust region.

from libc.stdint cimport int32_t, uint8_t

from arael.runtime.levenberg.component cimport Component


cdef class Dogleg:
    cdef readonly double floor          # of the regularisation
    cdef Vectors _vectors
    cdef Box _box
    cdef Component* _components
    cdef Py_ssize_t _count
    cdef const int32_t* _component      # of each scalar; NULL: all are of one
    cdef uint8_t* _cut                  # whether the step of each component was clamped
    cdef double* curvature              # [components] as `curvatures` leaves them
    cdef object _keep
    cdef bint _descended                # whether steepest descent is there
    cdef bint _pairs                    # whether steps of this attempt left pairs
    cdef bint _secant                   # whether there are pairs that were not used yet

    # A new linearisation of the whole, and one of a component that has moved.
    cdef void begin(self) noexcept nogil
    cdef void begin_component(self, Component* c) noexcept nogil
    # The matrix of a component was not positive definite.
    cdef void regularise(self, Component* c) noexcept nogil
    # The step in `vectors` is the Gauss-Newton step; the square root of a component's energy is the
    # length of its state.
    cdef void take_newton(self) noexcept nogil
    # Put the steps into `vectors`, each inside its region, and inside bounds; the reductions that
    # the model predicts.
    cdef void propose(self) noexcept nogil
    # Cut the steps in `vectors` off at the bounds; whether one was cut. Then the sums are new, and
    # the predicted reductions of the components of which it was.
    cdef bint clamp(self) noexcept nogil
    # step' H step of each component, with the present values.
    cdef void curvatures(self, const void* step) noexcept nogil
    # Move the radius after a step of gain ratio `gain`.
    cdef void adapt(self, Component* c, double gain) noexcept nogil
    # Keep the pairs that accepted steps leave; before the next linearisation.
    cdef void keep_pairs(self) noexcept nogil

    cdef void _descend(self) noexcept nogil
    cdef void _take_secants(self) noexcept nogil
    cdef void _cut_path(self, Py_ssize_t k) noexcept nogil
    cdef void _take_path(self, Component* c, double* along, double* across) noexcept nogil


cdef Dogleg dogleg_of(
    Vectors vectors, Box box, double floor, components, const int32_t* component)
