# The loop of a solve: plain C state, so that an iteration touches no Python object.

from libc.stdint cimport int32_t, int64_t, uint8_t

from arael.runtime.levenberg.box cimport Box
from arael.runtime.evaluation.component_lanes cimport ComponentLanes
from arael.runtime.levenberg.dogleg cimport Dogleg
from arael.runtime.levenberg.component cimport Component
from arael.runtime.levenberg.settings cimport Settings
from arael.runtime.levenberg.supervised cimport Supervised
from arael.runtime.levenberg.vectors cimport Vectors


# What became of a component. The layout of `COMPONENT` in lm.pyx.
ctypedef struct Ended:
    int64_t status
    int64_t iterations
    int64_t accepted
    double start_cost
    double end_cost
    double predicted_decrease


cdef class Minimiser(Supervised):
    cdef readonly double start_cost
    cdef readonly double current_cost
    cdef readonly Py_ssize_t accepted
    # Of the whole system, failed ones counted, and their seconds but for the first.
    cdef readonly Py_ssize_t factorisations
    cdef readonly double factor_seconds
    cdef readonly double damping          # largest lambda of the next attempt
    cdef readonly Vectors vectors
    cdef readonly Dogleg dogleg
    cdef readonly double predicted_decrease  # by the last linearisations, least damped
    cdef readonly double gradient_norm       # sqrt of the sum of g_i^2 / H_ii
    cdef readonly double noise_floor         # of the cost, by rounding

    cdef Settings _settings
    cdef object _driver
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
    cdef bint _all_accepted               # whether no component stays where it was
    cdef double _reached                  # cost of the whole after the attempt
    cdef bint _ending                     # whether components end with what was just done
    cdef bint _retiring                   # whether components have ended that are in the system
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

    cdef void _run(self) noexcept nogil
    cdef void _start_components(self) noexcept nogil
    cdef void _linearise(self) noexcept nogil
    cdef void _begin_components(self) noexcept nogil
    cdef void _end_at_linearisation(self) noexcept nogil
    cdef void _attempt(self) noexcept nogil
    cdef bint _may_attempt(self) noexcept nogil
    cdef bint _factor(self) noexcept nogil
    cdef void _blame(self, Py_ssize_t pivot) noexcept nogil
    cdef void _take_noise(self) noexcept nogil
    cdef void _empty_sums(self) noexcept nogil
    cdef void _keep_noise(self, Component* c, double energy) noexcept nogil
    cdef void _propose_damped(self) noexcept nogil
    cdef void _look_ahead(self) noexcept nogil
    cdef void _take_costs(self, int which) noexcept nogil
    cdef void _conclude(self) noexcept nogil
    cdef void _next_damping(self, Component* c) noexcept nogil
    cdef void _ask_driver(self) noexcept nogil
    cdef void _judge(self) noexcept nogil
    cdef void _accept(self) noexcept nogil
    cdef void _measure(self) noexcept nogil
    cdef void _measure_tried(self) noexcept nogil
    cdef void _end(self, Component* c, int status) noexcept nogil
    cdef void _retire(self) noexcept nogil
    cdef void _empty_retired(self) noexcept nogil
    cdef void _count_in_vain(self) noexcept nogil
    cdef int _worst(self) noexcept nogil
    cdef void _finish(self) noexcept nogil
