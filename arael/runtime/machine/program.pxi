"""The expression machine: runs groups without a compiled kernel, without Python and the GIL.

A program is a tape with registers instead of nodes. Each instruction works on a block of `WIDTH`
instances at a time, so that its dispatch is paid once a block and its loop is a vector loop of the
C compiler. It keeps NaN where kernels do.
"""

import ctypes
import sys

import msgspec
import numpy as np

from cython cimport floating
from libc.math cimport NAN
from libc.stdint cimport SIZE_MAX, int32_t
from libc.stdlib cimport free, malloc
from libc.string cimport memcmp

from arael.runtime.address cimport address
from arael.runtime.kernel cimport Lanes, Native

from arael.runtime.machine.assembling import INSTRUCTIONS, LIBRARY, assemble

cdef enum:
    LANES = 32

WIDTH = LANES
"""Instances of a block, and lanes of the arrays that programs read."""

cdef extern from "machine.h":
    const int ARAEL_INSTRUCTION_COUNT
    void execute_f64(
        int operation, int n, double* t, const double* a, const double* b, const double* c
    ) noexcept nogil
    void execute_f32(
        int operation, int n, float* t, const float* a, const float* b, const float* c
    ) noexcept nogil

# Numbers beyond those of the instructions.
cdef int CALL = len(INSTRUCTIONS)
cdef int LIBRARY_CALL = CALL + 1

if len(INSTRUCTIONS) != ARAEL_INSTRUCTION_COUNT:
    raise ImportError("the table of operations has other instructions than this module: build it")

# Functions of the C library that have no instruction, by address.
ctypedef double (*unary)(double) noexcept nogil
ctypedef double (*binary)(double, double) noexcept nogil

cdef unary* functions = <unary*>malloc(max(len(LIBRARY), 1) * sizeof(unary))


def _bind():
    names = ctypes.CDLL("ucrtbase" if sys.platform == "win32" else None)
    for k, function in enumerate(LIBRARY):
        found = ctypes.cast(getattr(names, function.library), ctypes.c_void_p).value
        functions[k] = <unary><size_t>found


_bind()


cdef void run(
    const Code* code, floating** registers, int n, const Native* natives, double* arguments
) noexcept nogil:
    """Execute instructions on `n` lanes of every register.

    A CALL has the number of a native function and the first of its operands in `code.operands`;
    `arguments` is workspace for its operands.
    """
    cdef Py_ssize_t at
    cdef const int32_t* word
    cdef floating *t
    cdef floating *a
    cdef floating *b
    cdef floating *c
    cdef const Native* native
    cdef unary function
    cdef const int32_t* operand
    cdef Py_ssize_t k
    cdef int w, op
    for at in range(code.count):
        word = code.words + 5 * at
        op = word[0]
        if op == CALL:
            t, native, operand = registers[word[1]], natives + word[2], code.operands + word[3]
            for w in range(n):
                for k in range(native.arity):
                    arguments[k] = registers[operand[k]][w]
                t[w] = <floating>native.call(native, arguments)
            continue
        if op == LIBRARY_CALL:
            t, a = registers[word[1]], registers[word[2]]
            function = functions[word[4]]
            if word[3] >= 0:
                b = registers[word[3]]
                for w in range(n):
                    t[w] = <floating>(<binary>function)(a[w], b[w])
            else:
                for w in range(n):
                    t[w] = <floating>function(a[w])
            continue
        t, a, b, c = registers[word[1]], registers[word[2]], registers[word[3]], registers[word[4]]
        if floating is float:
            execute_f32(op, n, t, a, b, c)
        else:
            execute_f64(op, n, t, a, b, c)


cdef class Program:
    """The programs of one group: its residuals, and its residuals with their derivatives.

    Registers are numbered: states, data, uniforms, constants, then what instructions compute.

    Parameters
    ----------
    group : arael.runtime.layout.Group
    entities : all entities of the layout
    single : f32 if true, else f64
    natives : names of the native functions, in the order in which lanes number them
    """

    def __init__(self, group, entities, single, natives=()):
        parts = assemble(group, entities, natives)
        self.single = single
        self.uses = len(group.uses)
        self.residuals = group.residuals
        self._states, self._data = len(group.states), group.data_count
        self._uniforms, self._constants = group.uniform_count, len(parts.constants)
        self._registers, self._arguments = parts.registers, parts.arguments
        arrays = [
            np.ascontiguousarray(a, dtype=np.int32)
            for a in (parts.cost, parts.full, parts.states, parts.results, parts.entries,
                      parts.products, parts.operands)
        ]
        constants = np.ascontiguousarray(parts.constants, dtype=np.float64)
        self._keep = (arrays, constants)
        self._cost.count, self._full.count = len(arrays[0]), len(arrays[1])
        self._cost.words = <const int32_t*>address(arrays[0], np.int32)
        self._full.words = <const int32_t*>address(arrays[1], np.int32)
        self._state = <const int32_t*>address(arrays[2], np.int32)
        self._results = <const int32_t*>address(arrays[3], np.int32)
        self._entries = <const int32_t*>address(arrays[4], np.int32)
        self._products = <const int32_t*>address(arrays[5], np.int32)
        self._entry_count, self._product_count = len(arrays[4]), len(arrays[5])
        self._cost.operands = self._full.operands = <const int32_t*>address(arrays[6], np.int32)
        self._constant = <const double*>address(constants, np.float64)
        for name, tape, columns in group.written:
            # The data keeps its columns: only what is computed differs.
            written = Program(
                msgspec.structs.replace(
                    group, tape=tape, residuals=len(columns), jacobian=(), moving_guard=None,
                    arguments=None),
                entities, single, natives)
            written.write_into(columns)
            if name == "guard":
                self.guarded, self._guard = True, written
            else:
                self.looks_up, self._arguments_of = True, written

    def write_into(self, columns):
        """Let the residuals be written into these columns of the data."""
        self._lanes_written = np.array(columns, dtype=np.int32)
        self._written = <const int32_t*>address(self._lanes_written, np.int32)

    @property
    def instructions(self):
        """Instructions of the cost and of the linearisation."""
        return self._cost.count, self._full.count

    @property
    def workspace(self):
        """Bytes that a run takes for its registers."""
        return workspace_of(self, sizeof(float) if self.single else sizeof(double))

    cdef double cost(self, const Lanes* lanes, double* costs, bint* exhausted) noexcept nogil:
        if self.single:
            return cost_of[float](self, lanes, costs, exhausted, <float*>NULL)
        return cost_of[double](self, lanes, costs, exhausted, <double*>NULL)

    cdef double linearise(
        self, const Lanes* lanes, bint shared, void* gradient, void* values, bint* exhausted
    ) noexcept nogil:
        if self.single:
            return linearise_of[float](
                self, lanes, shared, exhausted, <float*>gradient, <float*>values)
        return linearise_of[double](
            self, lanes, shared, exhausted, <double*>gradient, <double*>values)

    cdef void rows(
        self, const Lanes* lanes, void* residuals, void* entries, bint* exhausted
    ) noexcept nogil:
        if self.single:
            rows_of[float](self, lanes, exhausted, <float*>residuals, <float*>entries)
        else:
            rows_of[double](self, lanes, exhausted, <double*>residuals, <double*>entries)

    cdef void guard(self, const Lanes* lanes, bint* exhausted) noexcept nogil:
        if self.single:
            write_of[float](self._guard, lanes, True, exhausted, <float*>NULL)
        else:
            write_of[double](self._guard, lanes, True, exhausted, <double*>NULL)

    cdef void arguments(self, const Lanes* lanes, bint* exhausted) noexcept nogil:
        if self.single:
            write_of[float](self._arguments_of, lanes, False, exhausted, <float*>NULL)
        else:
            write_of[double](self._arguments_of, lanes, False, exhausted, <double*>NULL)


cdef size_t workspace_of(Program p, size_t scalar) noexcept nogil:
    return p._registers * (sizeof(void*) + LANES * scalar) + p._arguments * sizeof(double)


cdef size_t most_workspace = SIZE_MAX


def limit_workspace(most=None):
    """Refuse more bytes of registers than `most` as if there was no memory; None: no limit."""
    global most_workspace
    most_workspace = SIZE_MAX if most is None else most


cdef floating** program_registers(
    Program p, const Lanes* lanes, bint* exhausted, floating* _
) noexcept nogil:
    """Registers with what is the same for all blocks in them.

    Without memory NULL, and `exhausted` is set: threads share it, but nothing else is ever stored.
    """
    cdef Py_ssize_t k, w, pointers = p._registers * sizeof(void*)
    cdef Py_ssize_t fixed = p._states + p._data
    cdef size_t size = workspace_of(p, sizeof(floating))
    cdef char* workspace = <char*>malloc(size) if size <= most_workspace else NULL
    cdef floating** registers = <floating**>workspace
    cdef floating* memory = <floating*>(workspace + pointers)
    cdef floating value
    if workspace == NULL:
        exhausted[0] = True
        return NULL
    for k in range(p._registers):
        registers[k] = memory + k * LANES
    for k in range(p._uniforms + p._constants):
        if k < p._uniforms:
            value = (<const floating*>lanes.uniform)[k]
        else:
            value = <floating>p._constant[k - p._uniforms]
        for w in range(LANES):
            registers[fixed + k][w] = value
    return registers


cdef double* program_arguments(Program p, floating** registers) noexcept nogil:
    """Workspace for the arguments of a call, behind the registers."""
    return <double*>(registers[0] + p._registers * LANES)


cdef int gather(
    Program p, const Lanes* lanes, Py_ssize_t block, floating** registers
) noexcept nogil:
    """Bring states and data of a block into the registers; return its number of instances."""
    cdef Py_ssize_t k, w
    cdef const int32_t* state
    cdef const int32_t* row
    cdef const floating* source
    cdef int n = <int>min(<Py_ssize_t>LANES, lanes.n - block * LANES)
    for k in range(p._states):
        state = p._state + 3 * k
        row = lanes.row + (block * p.uses + state[0]) * LANES
        source = (<const floating*>lanes.state[state[0]]) + state[1]
        for w in range(n):
            registers[k][w] = source[<Py_ssize_t>row[w] * state[2]]
    for k in range(p._data):
        # Nothing writes to it: targets of instructions are numbered behind the inputs.
        registers[p._states + k] = (<floating*>lanes.data) + (block * p._data + k) * LANES
    return n


cdef double squares(Program p, floating** registers, int n) noexcept nogil:
    cdef Py_ssize_t k, w
    cdef double total = 0, r
    for k in range(p.residuals):
        for w in range(n):
            r = registers[p._results[k]][w]
            total += r * r
    return total


cdef void each_square(Program p, floating** registers, int n, double* costs) noexcept nogil:
    """Squared residuals of each instance of a block."""
    cdef Py_ssize_t k, w
    cdef double r
    for w in range(n):
        costs[w] = 0
    for k in range(p.residuals):
        for w in range(n):
            r = registers[p._results[k]][w]
            costs[w] += r * r


cdef void write_of(
    Program p, const Lanes* lanes, bint truth, bint* exhausted, floating* _
) noexcept nogil:
    """Write residuals into columns of the data; as 1 or 0 where they are the `truth` of a guard."""
    cdef floating** registers = program_registers(p, lanes, exhausted, _)
    cdef Py_ssize_t block, k
    cdef floating* column
    cdef const floating* value
    cdef int n, w
    if registers == NULL:
        return
    for block in range((lanes.n + LANES - 1) // LANES):
        n = gather(p, lanes, block, registers)
        run(&p._cost, registers, n, lanes.natives, program_arguments(p, registers))
        for k in range(p.residuals):
            column = (<floating*>lanes.data) + (block * p._data + p._written[k]) * LANES
            value = registers[p._results[k]]
            for w in range(n):
                column[w] = (value[w] != 0 and value[w] == value[w]) if truth else value[w]
    free(registers)


cdef double cost_of(
    Program p, const Lanes* lanes, double* costs, bint* exhausted, floating* _
) noexcept nogil:
    cdef floating** registers = program_registers(p, lanes, exhausted, _)
    cdef double total = 0
    cdef Py_ssize_t block
    cdef double* arguments
    cdef int n
    if registers == NULL:
        return NAN
    arguments = program_arguments(p, registers)
    for block in range((lanes.n + LANES - 1) // LANES):
        n = gather(p, lanes, block, registers)
        run(&p._cost, registers, n, lanes.natives, arguments)
        if costs != NULL:
            each_square(p, registers, n, costs + block * LANES)
        else:
            total += squares(p, registers, n)
    free(registers)
    return total


cdef double linearise_of(
    Program p, const Lanes* lanes, bint shared, bint* exhausted, floating* gradient,
    floating* values,
) noexcept nogil:
    cdef floating** registers = program_registers(p, lanes, exhausted, gradient)
    cdef double total = 0
    cdef Py_ssize_t block
    cdef double* arguments
    cdef int n
    if registers == NULL:
        return NAN
    arguments = program_arguments(p, registers)
    for block in range((lanes.n + LANES - 1) // LANES):
        n = gather(p, lanes, block, registers)
        run(&p._full, registers, n, lanes.natives, arguments)
        total += squares(p, registers, n)
        add_gradient(p, lanes, block, n, shared, registers, gradient)
        add_products(p, lanes, block, n, shared, registers, values)
    free(registers)
    return total


cdef void add_gradient(
    Program p, const Lanes* lanes, Py_ssize_t block, int n, bint shared,
    floating** registers, floating* gradient,
) noexcept nogil:
    """Add J'r."""
    cdef Py_ssize_t k, w, use, tangent
    cdef const int32_t* entry
    cdef const int32_t* at
    cdef const floating* j
    cdef const floating* r
    cdef double total
    for k in range(p._entry_count):
        entry = p._entries + 3 * k
        j, r = registers[entry[0]], registers[p._results[entry[1]]]
        use, tangent = entry[2] & 0xffff, entry[2] >> 16
        at = lanes.gradient_at + (block * p.uses + use) * LANES
        if shared:
            total = 0
            for w in range(n):
                total += <double>(j[w] * r[w])
            gradient[at[0] + tangent] += <floating>total
        else:
            for w in range(n):
                gradient[at[w] + tangent] += j[w] * r[w]


cdef void add_products(
    Program p, const Lanes* lanes, Py_ssize_t block, int n, bint shared,
    floating** registers, floating* values,
) noexcept nogil:
    """Add the lower half of J'J: offsets by whether a block is turned, as `Lanes.turn` says."""
    cdef Py_ssize_t k, w, first, pairs = p.uses * (p.uses + 1) // 2
    cdef const int32_t* product
    cdef const floating* i
    cdef const floating* j
    cdef floating[LANES] sums
    cdef int turn
    cdef double total
    cdef bint begins = True
    for k in range(p._product_count):
        product = p._products + 7 * k
        i, j = registers[product[0]], registers[product[1]]
        if begins:
            for w in range(n):
                sums[w] = i[w] * j[w]
        else:
            for w in range(n):
                sums[w] += i[w] * j[w]
        # Products of other residuals that go to the same place are added first.
        begins = k + 1 == p._product_count or memcmp(
            product + 2, product + 9, 5 * sizeof(int32_t)) != 0
        if not begins:
            continue
        first = (block * pairs + product[2]) * LANES
        if shared:
            total = 0
            for w in range(n):
                total += <double>sums[w]
            turn = lanes.turn[first]
            if turn == 2:
                total *= product[6]
            values[lanes.block_at[first] + product[3 + turn]] += <floating>total
        else:
            for w in range(n):
                turn = lanes.turn[first + w]
                values[lanes.block_at[first + w] + product[3 + turn]] += (
                    sums[w] * (product[6] if turn == 2 else 1)
                )


cdef void rows_of(
    Program p, const Lanes* lanes, bint* exhausted, floating* residuals, floating* entries
) noexcept nogil:
    cdef floating** registers = program_registers(p, lanes, exhausted, residuals)
    cdef Py_ssize_t block, k, w, first
    cdef double* arguments
    cdef int n
    if registers == NULL:
        return
    arguments = program_arguments(p, registers)
    for block in range((lanes.n + LANES - 1) // LANES):
        n = gather(p, lanes, block, registers)
        run(&p._full, registers, n, lanes.natives, arguments)
        first = block * LANES
        for w in range(n):
            for k in range(p.residuals):
                residuals[(first + w) * p.residuals + k] = registers[p._results[k]][w]
            for k in range(p._entry_count):
                entries[(first + w) * p._entry_count + k] = registers[p._entries[3 * k]][w]
    free(registers)
