# Factor of J J' by components: least-norm steps and projections onto the null space of J.
#
# With S the scales of the unknowns (zero where fixed) and W those of the rows, V = W J S has rows
# of unit length and the factor is that of V V' + M, where damping M = mu |longest row|^2 W^2.

from libc.stdint cimport int32_t, uint8_t

from arael.runtime.compiled cimport Interruption


cdef class RowFactor:
    cdef readonly Py_ssize_t n, m, count, components
    cdef double least_square                # squared length up to which a row holds nothing
    cdef readonly double pivot_tolerance    # squared sine below which a row depends on earlier ones
    cdef Interruption interruption          # looked at before every row
    cdef object _keep
    # As in structure.Structure.
    cdef const int32_t* row_of
    cdef const int32_t* start
    cdef const int32_t* unknown
    cdef const int32_t* source
    cdef const int32_t* column_start
    cdef const int32_t* column_position
    cdef const int32_t* column_entry
    cdef const int32_t* component_start
    cdef const int32_t* unknown_start
    cdef const int32_t* unknown_list
    cdef const int32_t* component_of
    cdef const int32_t* factor_start
    cdef const int32_t* factor_row
    cdef const int32_t* pattern_start
    cdef const int32_t* pattern_column
    cdef double* scale          # [n] S
    cdef double* row_scale      # [count] W
    cdef double* value          # [entries] V
    cdef double* factor_value   # L
    cdef double* inverse        # [count] 1 / pivot, zero where the row was dropped
    cdef double* work           # [count] zero between calls
    cdef double* solution       # [count]
    cdef int32_t* filled        # [count]
    cdef uint8_t* basic         # [count] rows that may have a pivot

    # Take the entries of the rows of a component into V.
    cdef void load(self, Py_ssize_t c, const double* entries) noexcept nogil
    # Factor V V' + M; returns the number of rows dropped, -1 if it was broken off: no factor then.
    cdef Py_ssize_t factor(self, Py_ssize_t c, double mu) noexcept nogil
    # `solution` becomes (V V' + M)^-1 solution.
    cdef void solve(self, Py_ssize_t c) noexcept nogil
    # The least-norm step for residuals r [m]: d = -S V' (V V' + M)^-1 W r.
    cdef void step(self, Py_ssize_t c, const double* r, double* d) noexcept nogil
    # v, in scaled unknowns, becomes its projection onto the null space of V.
    cdef void project(self, Py_ssize_t c, double* v) noexcept nogil
    # v becomes v - V' (V V')^-1 V v once; the squared length of what was taken away.
    cdef double reduce(self, Py_ssize_t c, double* v) noexcept nogil
