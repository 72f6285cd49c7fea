# Rows of entities and instances of constraints as variables and terms of a `BlockTree`.

from arael.runtime.evaluation.compiled cimport CompiledGroups, Raised
from arael.runtime.kernel cimport refresh_function


cdef struct EntityRows:
    int stored, stride, tangent
    bint plain                   # whether a step is just added
    refresh_function refresh     # or NULL
    void* program                # machine.TapeProgram in its place, or NULL
    size_t frame                 # bytes of stack that suffice for `refresh`
    Py_ssize_t count, room
    double* linear               # [room][stride] states at the linearisation points
    double* estimate             # [room][stride] states moved by the steps
    IntList unused               # rows that are free


cdef struct GroupTerms:
    int residuals, uses, columns, entries, lanes
    bint guarded                 # whether a guard reads parameters
    int* entity                  # [uses]
    int* place                   # [entries] in the rows of a term's Jacobian
    Py_ssize_t count, room
    double* data                 # [room][columns]
    int* term                    # [room]
    double* uniform
    IntList unused
    IntList batch                # terms to evaluate


cdef class Linearisations:
    cdef readonly BlockTree tree
    cdef EntityRows* entities
    cdef GroupTerms* groups      # one more than there are: its batch are priors
    cdef Py_ssize_t entity_count, group_count
    cdef CompiledGroups compiled
    cdef Raised raised
    cdef object _keep
    cdef dict priors             # number of a term that Python evaluates -> function
    cdef IntList stale           # variables to be linearised anew
    cdef IntList dirty           # variables that moved since `take_moved`
    cdef IntList unevaluated     # terms without a Jacobian at their linearisation points
    cdef readonly double cost    # at the estimate
    cdef readonly double error   # of the linearisation, where it is above the tolerance
    cdef readonly long long relinearised, evaluated
    cdef void* buffers[6]
    cdef Py_ssize_t rooms[6]

    cdef void* buffer(self, int number, Py_ssize_t size) except NULL
    cdef int _mark(self, IntList* list, bint stale, int v) except -1
    cdef bint _has_step(self, int v) noexcept
    cdef int _note_moved(self, int t) except -1
    cdef double[:, ::1] _prior(self, int t, bint at_estimate)
    cdef int _linearise(self) except -1
    cdef int _move(self) except -1
    cdef int _refresh(
        self, int e, Py_ssize_t n, const double* state, const double* step, double* moved
    ) except -1
    cdef int _check(self, double tolerance) except -1
    cdef int _compare(
        self, Term* term, const double* residuals, Py_ssize_t stride, double tolerance
    ) except -1
    cdef int _evaluate(
        self, int g, bint at_estimate, double** residuals, double** entries) except -1
