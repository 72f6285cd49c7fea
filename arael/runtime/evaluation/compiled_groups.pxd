# What runs each group without Python: a kernel, or a program of the expression machine.

from arael.runtime.kernel cimport Kernel, Lanes


cdef struct Compiled:
    void* program                # machine.Program, or NULL
    const Kernel* kernel         # or NULL
    Py_ssize_t width             # lanes of its data
    size_t frame                 # bytes of stack that suffice for its kernels
    bint shared                  # whether all instances read the same rows
    bint free                    # whether threads may run it side by side


cdef class CompiledGroups:
    cdef readonly list widths    # lanes of each group's data
    cdef readonly list free      # whether threads may run each group side by side
    cdef readonly list stores    # whether each group heeds `Lanes.first`
    cdef bint exhausted          # set where there was no memory for registers or a stack
    cdef object _keep            # whatever the pointers point into
    cdef Compiled* _groups

    cdef double _elsewhere(
        self, Compiled* one, void (*call)(void*) noexcept nogil, const Lanes* lanes, void* first,
        void* second) noexcept nogil
    # Kernels may ask for the GIL, so the functions below must be called without it.
    # Whether a group has neither kernel nor program; it cannot be run here then.
    cdef bint missing(self, Py_ssize_t g) noexcept nogil
    # Whether threads may run it side by side.
    cdef bint sharable(self, Py_ssize_t g) noexcept nogil
    # The sum of squared residuals; with `costs`, those of each instance instead, see `Kernel.cost`.
    cdef double cost(self, Py_ssize_t g, const Lanes* lanes, double* costs) noexcept nogil
    cdef double linearise(
        self, Py_ssize_t g, const Lanes* lanes, void* gradient, void* values) noexcept nogil
    # Whether its kernel asks a guard over parameters.
    cdef bint guards(self, Py_ssize_t g) noexcept nogil
    cdef void guard(self, Py_ssize_t g, const Lanes* lanes) noexcept nogil
    cdef void rows(
        self, Py_ssize_t g, const Lanes* lanes, void* residuals, void* entries) noexcept nogil
