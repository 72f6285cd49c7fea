# A tape alone on the expression machine: on columns, or as the step of an entity's rows.

from libc.stdint cimport int32_t


cdef class TapeProgram:
    cdef readonly Py_ssize_t inputs, outputs
    cdef object _keep                   # arrays that the pointers below point into
    cdef Py_ssize_t _constants, _registers, _arguments
    cdef Code _code
    cdef const double* _constant        # [constants]
    cdef const int32_t* _results        # [outputs] registers

    # States of rows moved by a step, as `kernel.refresh_function`; false without memory for the
    # registers. The inputs are `stored` scalars and those of the step, the outputs the state.
    cdef bint refresh(
        self, bint single, Py_ssize_t stored, Py_ssize_t rows, const void* state, const void* step,
        const int32_t* delta_at, void* moved) noexcept nogil

    # At single points, again and again: registers with the constants in them, which `free` frees
    # (NULL without memory), and outputs of the tape with these, for tapes without native functions.
    cdef double** registers(self) noexcept nogil
    cdef void at(self, double** registers, const double* inputs, double* outputs) noexcept nogil
