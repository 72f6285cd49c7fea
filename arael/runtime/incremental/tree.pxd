# A block Cholesky factor that is edited: fronts of a multifrontal factorisation are kept, each with
# its update matrix, so that what lies above a change is eliminated anew from what lies below it.


cdef enum:
    UNOWNED = 0               # no variable of the term moves
    WAITING = 1              # for the next elimination
    OWNED = 2                # by the front that eliminates its first variable


# A residual block of some variables, `rows` x (`width` + 1): the Jacobian, then the residuals.
cdef struct Term:
    bint alive
    int count                # variables
    int rows                 # residuals
    int width                # scalars of all its variables
    int group, slot          # of the constraint, and the instance in it
    int owner                # UNOWNED, WAITING, or OWNED by a front
    int next                 # term that the same front owns, or -1
    int mark                 # stamp of the last visit
    int* variable            # [count]
    double* jacobian         # [rows][width + 1]
    double cost              # at the estimate, when it was last evaluated


cdef struct Variable:
    bint alive
    bint free                # whether some scalar moves
    int width
    int entity, slot         # row of the states of an entity
    int front                # that eliminates it, or -1
    int mark
    int local                # number among the affected ones
    bint stale               # to be linearised anew
    bint dirty               # moved since it was last asked for
    uint8_t* held            # [width] scalars that do not move
    IntList terms            # that read it; may name dead ones


cdef struct Front:
    bint alive
    bint marked              # to be replaced
    bint fresh               # eliminated since the last `descend`
    int parent, child, sibling  # fronts, or -1
    int term                 # first of its terms, or -1
    int count, eliminated    # variables; the first `eliminated` of them are eliminated here
    int* variable            # [count]
    int columns, below       # scalars eliminated, scalars below
    int tall, low            # leading dimensions of triangle and panel
    int undetermined         # scalars that no residual determines
    double* memory
    double* triangle         # [columns] Cholesky factor of the eliminated scalars
    double* panel            # [columns] rows below, then L^-1 b
    double* update           # [below + 1] Schur complement for the parent, then its right-hand side
    double* inverse          # [columns] of the diagonal
    double* mass             # [columns + below] diagonal of J'J without any elimination
    double* seen             # [below] steps of the scalars below, as its own were computed from


cdef class BlockTree:
    cdef Term* terms
    cdef Variable* variables
    cdef Front* fronts
    cdef Py_ssize_t term_count, variable_count, front_count
    cdef Py_ssize_t term_room, variable_room, front_room
    cdef readonly Py_ssize_t stride      # scalars kept for each variable
    cdef readonly Py_ssize_t live_terms, live_variables
    cdef readonly long long live_rows    # residuals of all terms
    cdef readonly long long refactored   # scalars that the last `eliminate` eliminated
    cdef IntList free_terms, free_variables, free_fronts
    cdef IntList dropped_terms, dropped_variables  # still named by fronts
    cdef IntList fresh                   # fronts since the last `descend`, children first
    cdef IntList touched                 # variables whose terms have changed
    cdef IntList pending                 # terms that no front owns
    cdef IntList recent                  # variables to be eliminated last
    cdef IntList moved                   # variables whose steps have changed
    cdef int stamp
    cdef double* delta                   # [variables][stride] steps from the linearisation points
    cdef double* shown                   # [variables][stride] the same when last listed in `moved`
    cdef double* scale                   # [variables][stride] square root of the diagonal of J'J
    cdef int* position                   # [variables] first scalar in the front at hand
    cdef double* dense                   # workspaces of growing size
    cdef Py_ssize_t dense_room
    cdef double* sweep                   # zeros, of `marginal`
    cdef Py_ssize_t sweep_room

    cdef int new_variable(self, int width) except -1
    cdef int new_term(self, int count, const int* variable, int rows) except -1
    cdef int drop_term(self, int t) except -1
    cdef int drop_variable(self, int v) except -1
    cdef int hold_variable(self, int v, const uint8_t* held) except -1
    cdef int touch_term(self, int t) except -1
    cdef int touch_terms(self, int v) except -1
    cdef eliminate(self)
    cdef int descend(self, double tolerance) except -1
    cdef double* workspace(self, Py_ssize_t count) except NULL
    cdef int _new_front(self) except -1
    cdef void _free_front(self, int f) noexcept
    cdef int _collect(self, IntList* affected, IntList* marked) except -1
    cdef _sequence(self, IntList* affected, IntList* starts, IntList* members)
    cdef _build(
        self, sequence, IntList* affected, IntList* starts, IntList* members, IntList* owned,
        IntList* orphans)
    cdef int _make_front(
        self, const int* variable, int eliminated, int count) except -1
    cdef int _factorise(self, int number) except -1
    cdef void _hang(self, int f, int parent) noexcept
    cdef int _assemble(self, Front* f) except -1
    cdef int _add_term(self, Front* f, Term* t) except -1
    cdef int _extend(self, Front* f, Front* child) except -1
    cdef void _factorise_carefully(self, Front* f) noexcept
    cdef int _solve_front(self, Front* f, double tolerance) except -1
    cdef bint _has_changed(self, Front* f, double tolerance) noexcept
