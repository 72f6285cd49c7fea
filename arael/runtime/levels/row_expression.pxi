"""An expression over quantities and unknowns that is subtracted from a row."""

import numpy as np

from arael.runtime.address cimport address
from arael.runtime.machine.compiled cimport TapeProgram
from libc.stdint cimport int32_t
from libc.stdlib cimport calloc, free


cdef class RowExpression:
    """A tape with its inputs, run at one point without allocation.

    Parameters
    ----------
    row : int
        The row from which it is subtracted.
    tape : Tape
        Inputs: quantities, unknowns, numbers. Outputs: the value, then its derivatives by each
        quantity and each unknown.
    quantities, unknowns : sequences of int
    numbers : sequence of float
    contributions : int
        Entries of the Jacobian that it adds to.
    """

    def __init__(self, row, tape, quantities, unknowns, numbers, contributions):
        self.quantities, self.unknowns = tuple(quantities), tuple(unknowns)
        self.arrays.row, self.arrays.contributions = row, contributions
        self.arrays.quantities, self.arrays.unknowns = len(self.quantities), len(self.unknowns)
        derivatives = len(self.quantities) + len(self.unknowns)
        if tape.natives:
            raise ValueError("an expression of a row cannot call native functions")
        if len(tape.outputs) != 1 + derivatives:
            raise ValueError(
                f"expected a value and {derivatives} derivatives as outputs of the tape, "
                f"found {len(tape.outputs)} outputs")
        count = derivatives + len(numbers)
        self._program = TapeProgram(tape, count)
        self._registers = self._program.registers()
        self.arrays.inputs = <double*>calloc(count + 1, sizeof(double))
        self.arrays.outputs = <double*>calloc(1 + derivatives, sizeof(double))
        self.arrays.quantity = <int32_t*>calloc(len(self.quantities) + 1, sizeof(int32_t))
        self.arrays.unknown = <int32_t*>calloc(len(self.unknowns) + 1, sizeof(int32_t))
        self.arrays.at = <int32_t*>calloc(contributions + 1, sizeof(int32_t))
        if not (self._registers and self.arrays.inputs and self.arrays.outputs
                and self.arrays.quantity and self.arrays.unknown and self.arrays.at):
            raise MemoryError
        for k, number in enumerate(self.quantities):
            self.arrays.quantity[<Py_ssize_t>k] = number
        for k, number in enumerate(self.unknowns):
            self.arrays.unknown[<Py_ssize_t>k] = number
        self.set_numbers(numbers)

    def __dealloc__(self):
        free(self._registers)
        free(self.arrays.inputs)
        free(self.arrays.outputs)
        free(self.arrays.quantity)
        free(self.arrays.unknown)
        free(self.arrays.at)

    @property
    def row(self):
        """The row from which it is subtracted."""
        return self.arrays.row

    def set_numbers(self, numbers):
        """Change the inputs that are numbers: parameters of the sketch."""
        cdef Py_ssize_t k, first = self.arrays.quantities + self.arrays.unknowns
        cdef Py_ssize_t count = self._program.inputs - first
        values = np.ascontiguousarray(numbers, dtype=np.float64).ravel()
        cdef const double* value = <const double*>address(values, np.float64)
        if len(values) != count:
            raise ValueError(f"expected {count} numbers, found {len(values)}")
        for k in range(count):
            self.arrays.inputs[first + k] = value[k]

    cdef void run(self) noexcept nogil:
        self._program.at(self._registers, self.arrays.inputs, self.arrays.outputs)
