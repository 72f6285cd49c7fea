# Instances of one constraint in lane order, in arrays that grow and are edited in place.

from libc.stdint cimport int32_t, uint8_t

from arael.runtime.kernel cimport Kernel, Lanes


# What there is of each instance; pointers change only when instances are added.
cdef struct LaneArrays:
    Py_ssize_t residuals        # of an instance
    Py_ssize_t entries          # of the Jacobian of an instance
    Py_ssize_t ref_count
    Py_ssize_t field_count
    Py_ssize_t count            # instances
    Py_ssize_t active           # of these, the first so many are evaluated
    int32_t* first              # [count] first row of the instance
    int32_t* ref                # [count][refs] offsets of unknowns; negative: constants
    double* field               # [count][fields]
    int32_t* at                 # [count][entries] positions in the pattern, or -1
    double* residual            # [count][residuals] as evaluated last
    double* entry               # [count][entries] the same
    const int32_t* begin        # [residuals + 1] first entry of each residual
    const int32_t* ref_of       # [entries] which ref it belongs to
    const int32_t* tangent      # [entries] and which of its scalars


cdef class LaneTable:
    cdef readonly object struct          # name of the struct
    cdef readonly tuple refs             # names of its refs
    cdef readonly tuple widths           # scalars of each ref's target
    cdef readonly tuple fields           # names of its scalars of data: `value`, `at[0]`
    cdef LaneArrays arrays
    cdef Py_ssize_t _uses, _data, _width, _capacity
    cdef object _keep                    # arrays and programs that pointers point into
    cdef const int32_t* _ref_of_use      # [uses]
    cdef const int32_t* _width_of_use    # [uses]
    cdef const int32_t* _field_of_data   # [data] where no formula prepares them, else NULL
    cdef const int32_t* _field_of_input  # [inputs] of the formulas that prepare the data
    cdef Py_ssize_t _inputs
    cdef void* _prepare                  # TapeProgram, or NULL
    cdef double** _registers             # of it
    cdef double* _scratch                # its inputs and outputs
    cdef double* _defaults               # [fields], NaN where the data must be given
    cdef double* _lane_data              # [blocks][data][W]
    cdef int32_t* _lane_row              # [blocks][uses][W]
    cdef uint8_t* _run                   # [blocks] zeros: no lanes share rows
    cdef const void** _state             # [uses]
    cdef const Kernel* _kernel           # or NULL
    cdef void* _program                  # Program, or NULL
    cdef Lanes _lanes

    cdef reserve(self, Py_ssize_t count)
    cdef Py_ssize_t append(
        self, Py_ssize_t first, const int32_t* refs, const double* fields) noexcept nogil
    cdef void swap(self, Py_ssize_t i, Py_ssize_t j) noexcept nogil
    cdef void drop_last(self) noexcept nogil
    cdef void set_active(self, Py_ssize_t count) noexcept nogil
    # Fields or refs of an instance were written: bring them into the lanes.
    cdef void place(self, Py_ssize_t i) noexcept nogil
    # Residuals and entries of the active instances.
    cdef void evaluate(self, UnknownWindows unknowns) noexcept nogil
    # The same of a part: those that are evaluated together with instance i, which is active.
    cdef void evaluate_around(self, UnknownWindows unknowns, Py_ssize_t i) noexcept nogil
    cdef void _rows(
        self, const Lanes* lanes, double* residual, double* entry) noexcept nogil

    cdef double* _datum(self, Py_ssize_t i, Py_ssize_t k) noexcept nogil
    cdef int32_t* _row(self, Py_ssize_t i, Py_ssize_t k) noexcept nogil
    cdef void _pad(self) noexcept nogil
