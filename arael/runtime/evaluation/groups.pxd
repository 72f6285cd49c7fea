# The groups of a problem with all they read and add to, each evaluated by whatever can run it.

from arael.runtime.kernel cimport Lanes
from arael.runtime.assembly.compiled cimport Totals


cdef class Groups:
    cdef readonly bint single             # f32 if true, else f64
    cdef readonly Py_ssize_t size         # scalars of the system
    cdef readonly Py_ssize_t value_count  # scalars of its blocks
    cdef readonly Py_ssize_t shares       # parts that threads accumulate side by side
    cdef readonly StatePair states
    cdef readonly Totals totals           # the arrays of J'r and J'J
    cdef readonly Raised raised           # what Python raised meanwhile
    cdef CompiledGroups compiled
    cdef GroupLanes lanes
    cdef object _made_of                  # layout, kernels, programs, natives
    cdef object groups                    # of the layout
    cdef object orders                    # per group, that of its instances in lanes, or None
    cdef Py_ssize_t count                 # of them
    cdef readonly object hooks            # Hooks: groups evaluated by functions of the caller; None
    cdef readonly bint hooked             # whether there are any

    # Of one group: cost at one of the two states; NaN if a native function failed.
    cdef double group_cost_at(self, Py_ssize_t g, int which) noexcept nogil
    cdef double _checked(self, double value) noexcept nogil
    # Its guard over parameters is asked at the accepted state.
    cdef void guard_group(self, Py_ssize_t g) noexcept nogil
    # Its J'r and blocks of J'J at the accepted state are added to the arrays, or stored as the
    # lanes say.
    cdef double linearise_group(
        self, Py_ssize_t g, const Lanes* lanes, void* gradient, void* values) noexcept nogil
