# The states of all entities twice over: as accepted, and as a step would have them.

from libc.stdint cimport int32_t, int64_t, uint8_t

from arael.runtime.kernel cimport refresh_function


cdef struct EntityStates:
    void* state[2]               # [rows][stride] stored scalars, then caches
    const int32_t* delta_at      # [rows] first scalar of each row's step, or -1
    Py_ssize_t rows
    Py_ssize_t moving            # rows to refresh: all, or 0 if none moves
    Py_ssize_t stored            # stored scalars of a row
    Py_ssize_t stride            # state scalars of a row
    bint plain                   # whether a step is just added
    const int32_t* uses          # [use_count][4] first stored, stored, first tangent, tangent
    Py_ssize_t use_count
    bint curved                  # whether some parameter is a point of a manifold
    size_t frame                 # bytes of stack that suffice for `refresh`
    refresh_function refresh     # or NULL
    void* program                # machine.TapeProgram that moves rows in its place, or NULL


# What the threads of one move work on.
cdef struct Move:
    void* states
    const void* step


cdef class StatePair:
    cdef readonly bint single    # f32 if true, else f64
    cdef readonly int current    # which of the two is accepted
    cdef readonly list arrays    # [2][entities] (rows, state)
    cdef EntityStates* entities
    cdef Py_ssize_t _count
    cdef Py_ssize_t _size        # scalars of a step
    cdef object _layout          # of the entities
    cdef object _keep            # what the pointers point into
    cdef list _first             # the arrays of `delta_at`
    cdef object _still           # zeros: the step of who does not move
    cdef Raised _raised
    cdef Py_ssize_t _pieces      # of what moves
    cdef const int64_t* _piece   # [pieces][2] their runs
    cdef const int64_t* _run     # [runs][3] entity, first row, end; what moves
    cdef Py_ssize_t _runs
    cdef object _moving          # arrays of the two
    cdef bint _large             # whether they are worth sharing among threads
    cdef object _still_scalars   # the array of the next
    cdef const uint8_t* _held    # [size] scalars that do not move

    # The other states become the accepted ones moved by `step`.
    cdef void move(self, const void* step, int threads) noexcept nogil
    # The other states become the accepted ones.
    cdef void accept(self) noexcept nogil
    # The same for rows of some components only: `chosen` by component, `component` by scalar of the
    # system. Other rows stay as they are accepted.
    cdef void accept_chosen(self, const uint8_t* chosen, const int32_t* component) noexcept nogil
    # Accepted states of one entity.
    cdef void* at(self, Py_ssize_t entity) noexcept nogil
    # Euclidean norm of the stored scalars of all entities that are solved for.
    cdef double norm(self) noexcept nogil
    # Add the squares of the stored scalars of rows that are solved for, by component.
    cdef void add_squares(self, const int32_t* component, double* total) noexcept nogil
    # Sum of H_ii x_i^2 over the scalars that move, from the values of H and where its diagonal is:
    # how large the terms are that residuals are made of. A scalar of a tangent space, such as that
    # of a rotation, counts with the largest stored scalar of its parameter, and as no less than 1.
    cdef double energy(self, const void* values, const int64_t* diagonal_at) noexcept nogil
    # Add the same by component.
    cdef void add_energy(
        self, const void* values, const int64_t* diagonal_at, const int32_t* component,
        double* total) noexcept nogil

    cdef void _refresh_rows(
        self, Py_ssize_t e, Py_ssize_t begin, Py_ssize_t end, int source, int target,
        const void* step) noexcept nogil
    cdef void _move_piece(self, Py_ssize_t piece, const void* step) noexcept nogil
