# Steps that use the curvature which the last step found.

from arael.runtime.levenberg.component cimport Component


# Whether the step of gain ratio `gain` leaves a pair (step, change of the gradient) worth using.
cdef bint leaves_pair(const Component* c, double gain) noexcept nogil
# Choose the secant step of component k, from the sums `secant_...`; whether there is one.
cdef bint choose_secant(Component* c, Vectors vectors, Py_ssize_t k) noexcept nogil
# Whether the step in `vectors` may be tried; its length and what it promises.
cdef bint is_sound(Component* c, Vectors vectors, Py_ssize_t k) noexcept nogil
