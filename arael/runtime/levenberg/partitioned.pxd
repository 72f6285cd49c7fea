# The components of a solve.

from libc.stdint cimport int32_t, int64_t, uint8_t

from arael.runtime.evaluation.compiled cimport ComponentLanes
from arael.runtime.levenberg.component cimport Component


# What became of a component. The layout of `COMPONENT` in partitioned.pxi.
ctypedef struct Ended:
    int64_t status
    int64_t iterations
    int64_t accepted
    double start_cost
    double end_cost
    double predicted_decrease


cdef class Partitioned(Supervised):
    cdef readonly double current_cost
    cdef readonly Vectors vectors

    cdef Settings _settings
    cdef Box _box
    cdef Py_ssize_t _count                # of components
    cdef Py_ssize_t _running              # of those, that have not ended
    cdef Component* _components
    cdef readonly ComponentLanes lanes    # None: one component
    cdef const int32_t* _component        # of each scalar; NULL: all are of one
    cdef const int64_t* _value_runs       # [][3] begin, end and component of values
    cdef Py_ssize_t _value_run_count
    cdef double* _sums                    # [components + 1] costs or energies
    cdef uint8_t* _marks                  # [components + 1] which are evaluated
    cdef uint8_t* _accepts                # [components]
    cdef bint _retiring                   # whether components have ended that are in the system
    cdef bint _factored                   # whether the solver keeps a factor
    # Cost of components that have left the system, and of what reads nothing that is solved for.
    cdef double _settled
    cdef object _memory                   # of components, sums and flags
    # While only some components are left: see `_narrow`.
    cdef object _partition                # of the components; None: one component
    cdef object _whole                    # the linear solver of all
    cdef object _narrowed                 # arrays that are in use since
    cdef readonly Py_ssize_t narrowings
    cdef Py_ssize_t _scalars              # of the system as it was narrowed last
    cdef int64_t _in_vain                 # scalars that were passed over since
    cdef int64_t _constant, _multiple     # how many may be

    cdef void _take_costs(self, int which) noexcept nogil
    cdef void _take_noise(self) noexcept nogil
    cdef void _empty_sums(self) noexcept nogil
    cdef void _keep_noise(self, Component* c, double energy) noexcept nogil
    cdef void _measure(self) noexcept nogil
    cdef void _end(self, Component* c, int status) noexcept nogil
    cdef void _retire(self) noexcept nogil
    cdef void _empty_retired(self) noexcept nogil
    cdef void _count_in_vain(self) noexcept nogil
    cdef int _worst(self) noexcept nogil
