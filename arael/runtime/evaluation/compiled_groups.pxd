# What runs each group without Python: a kernel, or a program of the expression machine.

from libc.stdint cimport int32_t

from arael.runtime.kernel cimport Kernel, Lanes

# Where a look-up reads; see `arael.runtime.evaluation.look_up_tables`.
cdef struct Table:
    Py_ssize_t first             # column of the number of the interval; the record follows
    Py_ssize_t width             # scalars of a record
    Py_ssize_t intervals
    const void* records          # [intervals][width]
    const void* starts           # [intervals]
    const void* ends             # [intervals]
    const int32_t* range         # [intervals][2] intervals of the same owner
    bint clamp
    Py_ssize_t order             # rows of an interval
    const int32_t* near          # [intervals][order] these rows, where their parameters are read
    const int32_t* interval_of   # [rows] the interval in which a row is at the centre, or -1
    const int32_t* use           # [near_uses][2] use of an entity, which of the rows it is in
    Py_ssize_t near_uses
    Py_ssize_t centre            # use of an entity in the row at the centre, or -1


cdef struct Compiled:
    void* program                # machine.Program, or NULL
    const Kernel* kernel         # or NULL
    Py_ssize_t width             # lanes of its data
    size_t frame                 # bytes of stack that suffice for its kernels
    bint shared                  # whether all instances read the same rows
    bint free                    # whether threads may run it side by side
    Py_ssize_t data              # columns of its data
    Py_ssize_t look_ups
    Table* tables                # [look_ups] that its instances look up in
    Py_ssize_t uses              # entities that it uses
    const int32_t* rows          # as `Lanes.row`, of all instances
    int32_t* trial_rows          # the same at trial values; NULL if no look-up chooses rows
    bint required                # whether its residuals hold, and add nothing to the cost


cdef class CompiledGroups:
    cdef readonly list widths    # lanes of each group's data
    cdef readonly list free      # whether threads may run each group side by side
    cdef readonly list stores    # whether each group heeds `Lanes.first`
    cdef bint exhausted          # set where there was no memory for registers or a stack
    cdef object _keep            # whatever the pointers point into
    cdef list _tables            # per group, its tables, and the rows that they choose
    cdef bint _single
    cdef Py_ssize_t _count
    cdef Compiled* _groups

    cdef double _elsewhere(
        self, Compiled* one, void (*call)(void*) noexcept nogil, const Lanes* lanes, void* first,
        void* second) noexcept nogil
    cdef void _look_up(self, Compiled* one, const Lanes* lanes, bint trial) noexcept nogil

    # Kernels may ask for the GIL, so the functions below must be called without it. Before all of
    # them, look-ups are made at the states of the lanes.
    # Whether threads may run it side by side.
    cdef bint sharable(self, Py_ssize_t g) noexcept nogil
    # Whether its residuals hold, so that they are no part of the cost.
    cdef bint required(self, Py_ssize_t g) noexcept nogil
    # The sum of squared residuals; with `costs`, those of each instance instead, see `Kernel.cost`.
    cdef double cost(self, Py_ssize_t g, const Lanes* lanes, double* costs) noexcept nogil
    cdef double linearise(
        self, Py_ssize_t g, const Lanes* lanes, void* gradient, void* values) noexcept nogil
    # Whether it has a guard over parameters.
    cdef bint guards(self, Py_ssize_t g) noexcept nogil
    cdef void guard(self, Py_ssize_t g, const Lanes* lanes) noexcept nogil
    cdef void rows(
        self, Py_ssize_t g, const Lanes* lanes, void* residuals, void* entries) noexcept nogil
