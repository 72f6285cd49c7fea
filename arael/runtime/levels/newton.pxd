# Newton steps of least norm on rows that must hold, all touched components in step with each other.

from libc.stdint cimport int32_t, uint8_t

from arael.runtime.compiled cimport Interruption

cdef enum Status:
    SOLVED = 0
    RUNNING = 1
    STALLED = 2
    SIDE = 3
    NOT_FINITE = 4
    STEP_LIMIT = 5
    INTERRUPTED = 6
    IDLE = 7                    # not touched


cdef struct Component:
    int status
    int steps
    int row                     # with the largest residual, relative to its tolerance
    int guard                   # that stopped it, or -1
    int retries                 # shortened steps in a row
    int slow                    # steps in a row with hardly any progress
    int polished                # steps since the tolerance was met
    int limited                 # steps in a row that a guard shortened
    bint factored               # a factor is kept, maybe of another point
    bint kept                   # this step uses such a factor
    bint renew                  # a new step is due
    bint polishing              # solved already: one step more
    bint cut                    # a guard shortened this step
    double mu                   # damping, relative to rows of unit length
    double factored_mu
    double along                # fraction of the step
    double largest              # residual relative to its tolerance
    double norm                 # of the residuals
    double tried_largest
    double tried_norm
    int tried_row


cdef class Newton:
    cdef readonly Rows rows
    cdef readonly Rows guards
    cdef RowFactor factor
    cdef object _keep
    cdef object _parts
    cdef Component* part        # [components]
    cdef double* tolerance      # [m]
    cdef double* low            # [n], or NULL
    cdef double* high
    cdef double* scale          # [n] scales, zero where fixed; those of the factor: also where held
    cdef uint8_t* held          # [n] unknowns at an active bound: 1 low, 2 high
    cdef uint8_t* released      # [n] how often a bound was released in this solve
    cdef double* r              # [m] at x
    cdef double* tried_r        # [m]
    cdef double* entries
    cdef double* d              # [n] step
    cdef double* trial          # [n]
    cdef double* guard          # [guards] at x
    cdef double* tried_guard
    cdef double* trace          # [limit + 1][3] largest residual, factors made, damping
    cdef readonly int rounds, factors, limit, linearisations
    cdef double _last_check
    cdef object _failure
    cdef readonly Interruption interruption
    cdef double deadline        # lower levels end then; infinite without one
    cdef bint stopped           # interrupted, or a row raised

    cdef void restart(self, Py_ssize_t c, const double* x) noexcept nogil
    cdef int solve_parts(
        self, double* x, const int32_t* parts, Py_ssize_t count) noexcept nogil
    cdef bint measure(self, Py_ssize_t c, const double* r, double* largest, double* norm, int* row
                      ) noexcept nogil
    cdef int refactor(self, const double* x, const int32_t* parts, Py_ssize_t count) noexcept nogil
    cdef bint _factor(self, Py_ssize_t c, double mu) noexcept nogil
    cdef void _direction(self, Py_ssize_t c, double* x) noexcept nogil
    cdef void _place(self, Py_ssize_t c, const double* x) noexcept nogil
    cdef int _shorten(self, const double* x, const int32_t* parts, Py_ssize_t count) noexcept nogil
    cdef void _judge(self, Py_ssize_t c, double* x, bint finite) noexcept nogil
    cdef void _accept(self, Py_ssize_t c, double* x) noexcept nogil
    cdef void _reject(self, Py_ssize_t c, double* x) noexcept nogil
    cdef bint hold(self, Py_ssize_t c, const double* at, double* x) noexcept nogil
    cdef bint release(self, Py_ssize_t c) noexcept nogil
    cdef bint interrupted(self) noexcept nogil
    cdef bint late(self) noexcept nogil
