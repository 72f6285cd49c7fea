# An expression over quantities and unknowns that is subtracted from a row.

from libc.stdint cimport int32_t

from arael.runtime.machine.compiled cimport TapeProgram


cdef struct ExpressionArrays:
    Py_ssize_t row              # from which it is subtracted
    Py_ssize_t quantities, unknowns
    Py_ssize_t contributions    # entries it adds to
    double* inputs              # [quantities + unknowns + numbers]
    double* outputs             # value, then derivatives by quantities and unknowns
    int32_t* quantity           # [quantities] rows
    int32_t* unknown            # [unknowns] offsets
    int32_t* at                 # [contributions] positions of entries, by input


cdef class RowExpression:
    cdef readonly tuple quantities       # rows whose values are its first inputs
    cdef readonly tuple unknowns         # offsets of those that follow; numbers are the last
    cdef ExpressionArrays arrays
    cdef TapeProgram _program
    cdef double** _registers

    cdef void run(self) noexcept nogil
