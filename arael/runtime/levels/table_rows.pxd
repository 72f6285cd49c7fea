# Rows from tables of instances: their memory, their pattern and their evaluation.

from libc.stdint cimport int32_t, int64_t, uint8_t


# Instead of the number of a table.
cdef enum:
    FREE = -1                   # nothing is at the row
    FURTHER = -2                # a further row of the instance before it


# A multiple of an unknown that is added to a row.
cdef struct Term:
    int32_t row
    int32_t unknown
    int32_t next                # the row's next one, or -1
    int32_t at                  # position of its entry, or -1
    double coefficient


cdef class TableRows(Rows):
    cdef readonly UnknownWindows unknowns
    cdef readonly dict tables           # LaneTable by struct
    cdef list _table                    # the same in the order of the layout
    cdef void** _tables
    cdef LaneArrays** _arrays           # of these
    cdef Py_ssize_t _table_count
    # By row:
    cdef int32_t* _table_of             # number of the table; of other rows see FREE, FURTHER
    cdef int32_t* _index_of             # of the instance in its table
    cdef uint8_t* _shown                # whether it is an equation that is on
    cdef uint8_t* _quantity             # whether it only is an input of expressions
    cdef int32_t* _expression_of        # number of the expression subtracted from it, or -1
    cdef int32_t* _term_of              # number of its first term, or -1
    cdef Py_ssize_t _row_capacity
    cdef list _expression               # RowExpression or None
    cdef ExpressionArrays** _expressions
    cdef void** _expression_at          # RowExpression
    cdef Py_ssize_t _expression_count
    cdef Term* _terms
    cdef Py_ssize_t _term_count, _term_capacity
    # The pattern.
    cdef int32_t* _indptr
    cdef int32_t* _indices
    cdef Py_ssize_t _capacity           # of the indices
    cdef Py_ssize_t _most               # an upper bound of their number
    cdef int64_t* _mark                 # [n] number of the row in which the unknown was met last
    cdef int32_t* _slot                 # [n] and its position
    cdef int64_t _stamp
    cdef Py_ssize_t _mark_capacity
    cdef Py_ssize_t _stale              # first row whose pattern is out of date; m: none
    cdef int _editing
    # Instances that were evaluated since the rows were made, by excerpts as well.
    cdef readonly int64_t evaluated

    cdef LaneTable _table_at(self, Py_ssize_t row)
    cdef _reserve_rows(self, Py_ssize_t count)
    cdef _reserve_marks(self, Py_ssize_t n)
    cdef _touch(self, Py_ssize_t row)
    cdef _update(self)
    cdef int32_t _place(self, int32_t unknown, Py_ssize_t* end) noexcept nogil
    cdef void _pattern(self) noexcept nogil
    cdef void _show(self, Py_ssize_t row, bint on) noexcept nogil
    cdef void _activate(self, Py_ssize_t row, bint on) noexcept nogil
    cdef int _evaluate(self, const double* x, double* r, double* entries) noexcept nogil
    cdef void _express(self, double* r, double* entries) noexcept nogil
    cdef void _subtract(
        self, Py_ssize_t number, double* r, double* entries, Py_ssize_t shift) noexcept nogil
    cdef int _not_finite(self, const double* r, const double* entries) noexcept nogil
