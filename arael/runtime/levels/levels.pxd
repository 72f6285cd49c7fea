# Exact rows, then the cursor, then closeness: Newton steps of least norm on any `Rows`.

from libc.stdint cimport int32_t, uint8_t

from arael.runtime.levels.rows cimport Rows
from arael.runtime.orthogonal.rank_qr cimport RankQR


cdef class Levels:
    cdef readonly Rows rows
    cdef readonly Rows guards               # residuals whose sign is kept, or None
    cdef readonly Py_ssize_t factors        # made since the object was
    cdef RankQR qr                          # of J
    cdef RankQR damped                      # of [J, weights], made when first needed
    cdef Py_ssize_t version, guard_version
    cdef bint current                       # whether `qr` holds a factor that may be used again
    cdef object low, high                   # bounds of the unknowns
    cdef list kept                          # memory
    cdef int n, m, k, components
    # by row
    cdef double* r
    cdef double* trial_r
    cdef double* right
    cdef double* tolerance
    cdef uint8_t* active                    # rows that act now
    cdef uint8_t* wanted                    # rows that the caller wants
    cdef uint8_t* was_active                # of the factor
    cdef int32_t* of_row                    # component
    cdef double* entries
    cdef double* widened                    # entries of `damped`
    cdef double* weight                     # by row: its length
    cdef double* scale                      # of the unknowns of `damped`
    # by unknown
    cdef double* x
    cdef double* trial
    cdef double* d
    cdef int32_t* of_unknown
    # by guard
    cdef double* g
    cdef double* trial_g
    cdef int32_t* of_guard
    # bounded unknowns: their row, its entry, its place among the entries
    cdef int bounded
    cdef int32_t* slack
    cdef int32_t* slack_row
    cdef double* slack_entry
    cdef int32_t* slack_place
    cdef double* slack_low
    cdef double* slack_high
    # by component
    cdef uint8_t* state                     # SATISFIED, OPEN, FAILED
    cdef double* merit
    cdef double* trial_merit
    cdef double* t
    cdef double* before                     # merit at the start
    cdef uint8_t* accepted
    cdef int32_t* idle                      # steps in a row that gained next to nothing
    cdef int32_t* blocked_by                # guard that stopped the step, or -1
    cdef int bad_row

    cdef void* array(self, dtype, Py_ssize_t count) except? NULL
    cdef prepare(self)
    cdef int evaluate(self, double* x, double* r, double* g) noexcept nogil
    cdef void relax(self, double* x, double* r) noexcept nogil
    cdef void measure(self, const double* r, double* merit) noexcept nogil
    cdef bint closed(self) noexcept nogil
    cdef int renew(self) noexcept nogil
    cdef void step_into(self, double mu) noexcept nogil
    cdef int search(self, bint last) noexcept nogil
    cdef int run(self, int most) noexcept nogil
    cdef int sharpen(self) noexcept nogil
