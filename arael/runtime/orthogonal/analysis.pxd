# What the pattern of a matrix determines of its QR factorisation.

from libc.stdint cimport int64_t

from arael.runtime.compiled cimport Interruption


cdef struct Plan:
    int m                 # equations: columns of what is factored
    int n                 # unknowns: its rows
    int fronts
    int roots             # of trees of fronts: components that have an equation
    int64_t cells         # doubles of all fronts
    int64_t rows          # rows of all fronts, at most
    int widest            # most columns of a front
    int tallest           # most rows of a front
    int* by_unknown                # (n + 1) first entry of an unknown in the next two
    int* equation                  # (entries) equation
    int* source                    # (entries) place among the caller's entries
    int* local                     # (entries) column within the front of the unknown
    int* position                  # (m) place of an equation in the order of elimination
    int* at                        # (m) equation of a place
    int* front_of                  # (m) front of a place
    int* front_of_unknown          # (n) front that an unknown is a row of; -1: in no equation
    int* pivots                    # (fronts) columns that end in a front
    int64_t* columns               # (fronts + 1) first of a front in the next three
    int* column                    # places of the columns of a front, ascending
    int* upward                    # column's index within the parent's columns
    int* parent                    # (fronts) -1 for a root
    int* child                     # (fronts) first child, or -1
    int* sibling                   # (fronts) next child of the same parent, or -1
    int* root                      # (fronts)
    int* own                       # (fronts + 1) first of a front in `unknown`
    int* unknown                   # unknowns that are rows of a front
    int* lead                      # the same: column of an unknown's first entry in its front
    int64_t* first_row             # (fronts + 1) place of a front among all rows
    int64_t* first_cell            # (fronts + 1) place among all cells


cdef class Analysis:
    cdef Plan plan
    cdef Interruption interruption      # looked at by column here, by front in the factor
    cdef list kept                      # the arrays of all pointers below
    cdef list temporary                 # those that only the analysis needs

    cdef int* ints(self, Py_ssize_t count) except? NULL
    cdef int64_t* longs(self, Py_ssize_t count) except? NULL
    cdef int* scratch(self, Py_ssize_t count) except? NULL
    cdef transpose(self, const int* start, const int* entry)
    cdef ordering(self, const int* start, const int* entry)
    cdef symbolic(self, const int* start, const int* entry, const int* order)
    cdef make_fronts(
        self, const int* order, const int* parent, int* child, int* sibling,
        const int64_t* first, const int* pattern, const int* leftmost,
    )
    cdef place_rows(self, const int* post, const int* leftmost)
