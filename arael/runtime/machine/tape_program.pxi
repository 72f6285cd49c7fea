"""A tape alone on the expression machine: on columns, or as the step of an entity's rows."""

import numpy as np

from cpython.buffer cimport PyBUF_STRIDES, PyBuffer_Release, PyObject_GetBuffer
from cython cimport floating
from libc.stdint cimport int32_t
from libc.stdlib cimport free, malloc

from arael.runtime.address cimport address, writable
from arael.runtime.kernel cimport Native

from arael.runtime.machine.assembling import assemble_tape

# A column of scalars.
cdef struct Column:
    const char* first
    Py_ssize_t stride           # bytes; 0 for one value for all


cdef class TapeProgram:
    """The instructions of a tape.

    Registers are numbered: inputs, constants, then what instructions compute.

    Parameters
    ----------
    tape : arael.runtime.machine.tape.Tape
    inputs : number of inputs, read or not
    natives : names of the native functions, in the order of the table passed with the columns
    """

    def __init__(self, tape, inputs, natives=()):
        parts = assemble_tape(tape, inputs, natives)
        self.inputs, self.outputs = inputs, len(parts.results)
        self._constants, self._registers = len(parts.constants), parts.registers
        self._arguments = parts.arguments
        arrays = [
            np.ascontiguousarray(a, dtype=np.int32)
            for a in (parts.code, parts.operands, parts.results)
        ]
        constants = np.ascontiguousarray(parts.constants, dtype=np.float64)
        self._keep = arrays, constants
        self._code.count = len(arrays[0])
        self._code.words = <const int32_t*>address(arrays[0], np.int32)
        self._code.operands = <const int32_t*>address(arrays[1], np.int32)
        self._results = <const int32_t*>address(arrays[2], np.int32)
        self._constant = <const double*>address(constants, np.float64)

    def columns(self, inputs, Py_ssize_t n, dtype, NativeTable natives=None):
        """Outputs on columns.

        Parameters
        ----------
        inputs : one array (n,) or () per input, of `dtype`, with any stride
        dtype : float64 or float32
        natives : the native functions that the tape calls; failures of theirs are left in it

        Returns
        -------
        (outputs, n)

        Raises
        ------
        MemoryError
            There is no memory for the registers.
        """
        cdef Py_ssize_t k
        cdef bint done, single = dtype == np.float32
        cdef const Native* functions = NULL if natives is None else natives.items
        cdef void* target
        cdef Column* column
        cdef Py_buffer view
        found = np.empty((self.outputs, n), dtype=dtype)
        if not found.size:
            return found
        if len(inputs) != self.inputs:
            raise ValueError(f"expected {self.inputs} inputs, found {len(inputs)}")
        column = <Column*>malloc((self.inputs + 1) * sizeof(Column))
        if column == NULL:
            raise MemoryError
        try:
            for k in range(self.inputs):
                one = inputs[k]
                if one.dtype != dtype or one.ndim > 1 or (one.ndim and len(one) != n):
                    raise ValueError(f"input {k} is no column of {n} {dtype}")
                PyObject_GetBuffer(one, &view, PyBUF_STRIDES)
                column[k].first = <const char*>view.buf
                column[k].stride = view.strides[0] if view.ndim else 0
                PyBuffer_Release(&view)
            target = writable(found, dtype)
            with nogil:
                if single:
                    done = columns_of[float](self, column, n, functions, <float*>target)
                else:
                    done = columns_of[double](self, column, n, functions, <double*>target)
        finally:
            free(column)
        if not done:
            raise MemoryError("no memory for the registers of a formula")
        return found

    cdef bint refresh(
        self, bint single, Py_ssize_t stored, Py_ssize_t rows, const void* state, const void* step,
        const int32_t* delta_at, void* moved
    ) noexcept nogil:
        if single:
            return refresh_of[float](
                self, stored, rows, <const float*>state, <const float*>step, delta_at,
                <float*>moved)
        return refresh_of[double](
            self, stored, rows, <const double*>state, <const double*>step, delta_at,
            <double*>moved)

    cdef double** registers(self) noexcept nogil:
        cdef Py_ssize_t k, pointers = self._registers * sizeof(void*)
        cdef char* workspace = <char*>malloc(pointers + self._registers * sizeof(double))
        cdef double** registers = <double**>workspace
        if workspace == NULL:
            return NULL
        for k in range(self._registers):
            registers[k] = <double*>(workspace + pointers) + k
        for k in range(self._constants):
            registers[self.inputs + k][0] = self._constant[k]
        return registers

    cdef void at(self, double** registers, const double* inputs, double* outputs) noexcept nogil:
        cdef Py_ssize_t k
        for k in range(self.inputs):
            registers[k][0] = inputs[k]
        run(&self._code, registers, 1, NULL, NULL)
        for k in range(self.outputs):
            outputs[k] = registers[self._results[k]][0]


cdef floating** tape_registers(TapeProgram p, floating* _) noexcept nogil:
    """Registers with the constants in them, and workspace for arguments; NULL without memory."""
    cdef Py_ssize_t k, w, pointers = p._registers * sizeof(void*)
    cdef size_t size = pointers + p._registers * LANES * sizeof(floating)
    cdef char* workspace = NULL
    size += p._arguments * sizeof(double)
    if size <= most_workspace:
        workspace = <char*>malloc(size)
    cdef floating** registers = <floating**>workspace
    cdef floating* memory = <floating*>(workspace + pointers)
    if workspace == NULL:
        return NULL
    for k in range(p._registers):
        registers[k] = memory + k * LANES
    for k in range(p._constants):
        for w in range(LANES):
            registers[p.inputs + k][w] = <floating>p._constant[k]
    return registers


cdef double* tape_arguments(TapeProgram p, floating** registers) noexcept nogil:
    return <double*>(registers[0] + p._registers * LANES)


cdef bint columns_of(
    TapeProgram p, const Column* inputs, Py_ssize_t n, const Native* natives, floating* found
) noexcept nogil:
    cdef floating** registers = tape_registers(p, found)
    cdef Py_ssize_t k, block, first
    cdef int w, count
    cdef const char* at
    cdef const floating* result
    if registers == NULL:
        return False
    for k in range(p.inputs):
        if inputs[k].stride == 0:
            for w in range(LANES):
                registers[k][w] = (<const floating*>inputs[k].first)[0]
    for block in range((n + LANES - 1) // LANES):
        first = block * LANES
        count = <int>min(<Py_ssize_t>LANES, n - first)
        for k in range(p.inputs):
            if inputs[k].stride:
                at = inputs[k].first + first * inputs[k].stride
                for w in range(count):
                    registers[k][w] = (<const floating*>(at + w * inputs[k].stride))[0]
        run(&p._code, registers, count, natives, tape_arguments(p, registers))
        for k in range(p.outputs):
            result = registers[p._results[k]]
            for w in range(count):
                found[k * n + first + w] = result[w]
    free(registers)
    return True


cdef bint refresh_of(
    TapeProgram p, Py_ssize_t stored, Py_ssize_t rows, const floating* state,
    const floating* step, const int32_t* delta_at, floating* moved
) noexcept nogil:
    cdef floating** registers = tape_registers(p, moved)
    cdef Py_ssize_t k, block, first, stride = p.outputs
    cdef int w, count
    cdef const floating* result
    if registers == NULL:
        return False
    for block in range((rows + LANES - 1) // LANES):
        first = block * LANES
        count = <int>min(<Py_ssize_t>LANES, rows - first)
        for k in range(stored):
            for w in range(count):
                registers[k][w] = state[(first + w) * stride + k]
        for k in range(stored, p.inputs):
            for w in range(count):
                registers[k][w] = 0
                if delta_at[first + w] >= 0:
                    registers[k][w] = step[delta_at[first + w] + k - stored]
        run(&p._code, registers, count, NULL, tape_arguments(p, registers))
        for k in range(p.outputs):
            result = registers[p._results[k]]
            for w in range(count):
                moved[(first + w) * stride + k] = result[w]
    free(registers)
    return True
