# Cost, gradient and blocks of a whole problem, shared among threads.

from arael.runtime.parallel.compiled cimport Task


# What the threads of one evaluation work on.
cdef struct Work:
    void* evaluation
    void* gradient
    void* values
    double* costs                         # [shares]
    int which                             # of the two states
    void* chosen                          # ComponentLanes, or None: all of each share


cdef class Evaluation(Groups):
    cdef public int threads               # that share an evaluation
    cdef readonly bint guarded            # whether a guard of some instance reads parameters
    cdef readonly bint updating           # whether a linearisation may change data, and so costs

    # Cost at one of the two states; NaN if a native function failed.
    cdef double cost(self, int which) noexcept nogil
    # Costs of the instances at one of the two states, as far as they are chosen.
    cdef void costs(self, int which, ComponentLanes chosen) noexcept nogil
    # Guards over parameters are asked at the accepted state; `linearise` does so itself.
    cdef void guard(self) noexcept nogil
    # J'r and the blocks of J'J at the accepted state; scalars held fixed have an identity row.
    # Where lanes are chosen, what only others contribute to is undefined, and so is the cost.
    cdef double linearise(
        self, void* gradient, void* values, ComponentLanes chosen) noexcept nogil

    # Functions of the caller are called for the residuals at one of the two states, of one group or
    # (g < 0) of all; with derivatives too where these are needed.
    cdef void fill(self, int which, bint derivatives, Py_ssize_t g) noexcept nogil
    cdef _fill(self, int which, bint derivatives, Py_ssize_t g)
    cdef _update(self)
    cdef _add_curvature(self, void* gradient, void* values)

    cdef bint _whole(self, Py_ssize_t g) noexcept nogil
    cdef void _run_shares(self, Task task, Work* work) noexcept nogil
    cdef double _cost_of_share(self, Py_ssize_t share, int which) noexcept nogil
    cdef void _guard_share(self, Py_ssize_t share) noexcept nogil
    cdef double _linearise_share(
        self, Py_ssize_t share, void* gradient, void* values, ComponentLanes chosen
    ) noexcept nogil
    cdef void _costs_in_share(
        self, Py_ssize_t share, int which, ComponentLanes chosen) noexcept nogil
    cdef void _costs_of_chosen(
        self, Py_ssize_t g, Py_ssize_t share, int which, ComponentLanes chosen) noexcept nogil
    cdef double _linearise_chosen(
        self, Py_ssize_t g, Py_ssize_t share, void* gradient, void* values, ComponentLanes chosen
    ) noexcept nogil
