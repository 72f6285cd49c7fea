# Numeric factor of J' over the fronts of an analysis, and products with its parts.

from libc.stdint cimport int64_t, uint8_t

from arael.runtime.compiled cimport Interruption


cdef class Factor:
    cdef readonly Analysis analysis
    cdef Interruption interruption          # of the analysis
    cdef readonly int rank
    cdef readonly double smallest_kept      # least remaining length of an independent equation
    cdef readonly double largest_dropped    # greatest of a dependent one
    cdef list kept

    # A row of a front has a *slot*, the number of an unknown. Reflections act on slots in place, so
    # that Q'v overwrites v: slots with a pivot hold its first part, the others its last.
    cdef double* values             # entries of J', scaled, by unknown; the caller's part
    cdef double* cell               # fronts, column-major, with as many rows as `height`
    cdef double* tau                # by column of the fronts
    cdef int* pivot                 # the same: row of the pivot, or -1
    cdef int* stair                 # the same: one past the last row of its reflection
    cdef int* slot                  # by row of the fronts
    cdef int* height                # (fronts) rows
    cdef int* live                  # (fronts) rows that have ended with a pivot
    cdef int* reduced               # (fronts) rows that have a pivot in any column
    cdef int* lead                  # by row of the fronts: column of its pivot
    cdef double* norms              # (m) by place: remaining length of an equation
    cdef int* slot_of               # (m) by place: slot of the pivot; -1: dependent
    cdef int* front_of_slot         # (n) where a slot's last reflection was; -1: in no equation
    cdef uint8_t* free              # (n) whether a slot has no pivot

    # Workspace, all zero between calls where it says so.
    cdef double* work               # (n) slots, zero
    cdef double* multiplier         # (m) by place, zero
    cdef double* row                # (tallest) rows of one front
    cdef uint8_t* marked            # (fronts), zero
    cdef int* path                  # (fronts)
    cdef int* found                 # (fronts)
    cdef int* reached               # (n)

    cdef void* array(self, dtype, Py_ssize_t count) except? NULL
    cdef bint factor(self, double dead, double noise) noexcept nogil
    cdef void front(self, int f, double dead, double noise) noexcept nogil
    cdef void count(self) noexcept nogil
    cdef bint gather(self, int f, const double* v) noexcept nogil
    cdef void forward(self, int f, double* v) noexcept nogil
    cdef bint backward(self, int f, double* v) noexcept nogil
    cdef int climb(self, int f, int count) noexcept nogil
    cdef void release(self, int count) noexcept nogil
    cdef void multipliers(self, int f, double* v, double* x, double* largest) noexcept nogil
    cdef int solve_down(self, int count, double* x) noexcept nogil
    cdef bint reaches(self, int f, const double* x) noexcept nogil
    cdef void solve_up(self, double* x, double* v) noexcept nogil
    cdef int spread(self, int slot) noexcept nogil
