# How lambda follows success and failure of the damped steps of one component.

from arael.runtime.levenberg.component cimport Component

# Move lambda after an attempt of gain ratio `gain`; RUNNING, or how the component ends.
cdef int next_damping(Component* c, const Settings* s, double gain) noexcept nogil
