"""The states of all entities twice over: as accepted, and as a step would have them."""

import numpy as np

from libc.math cimport fabs, sqrt
from libc.stdint cimport int32_t, int64_t, uint8_t
from libc.stdlib cimport calloc, free
from libc.string cimport memcpy

from cython cimport floating

from arael.runtime.address cimport address, table_address, writable
from arael.runtime.kernel cimport KernelTable, table_of
from arael.runtime.machine.compiled cimport TapeProgram
from arael.runtime.parallel.compiled cimport distribute

from arael.runtime.machine.programs import entity_program
from arael.runtime.parallel.frames import refresh_frame_of
from arael.runtime.parallel.vector_parts import count_parts

# Rows between others that are moved with them, although they stay: a call takes as long as these.
cdef Py_ssize_t ROW_GAP = 4


cdef double squares(
    const floating* state, Py_ssize_t rows, Py_ssize_t stride, Py_ssize_t stored
) noexcept nogil:
    """Sum of the squares of the stored scalars of some rows."""
    cdef Py_ssize_t row, k
    cdef double total = 0, x
    for row in range(rows):
        for k in range(stored):
            x = state[row * stride + k]
            total += x * x
    return total


cdef void add_step(
    Py_ssize_t rows, Py_ssize_t width, const floating* state, const floating* step,
    const int32_t* at, floating* moved,
) noexcept nogil:
    """Rows of reals moved by the step at `at`, where there is one."""
    cdef Py_ssize_t row, k
    for row in range(rows):
        for k in range(width):
            moved[row * width + k] = state[row * width + k]
            if at[row] >= 0:
                moved[row * width + k] += step[at[row] + k]

cdef extern from "stack.h":
    bint stack_suffices(size_t need) noexcept nogil
    bint stack_elsewhere(size_t need, void (*call)(void*) noexcept nogil, void* job) noexcept nogil


# A call that needs another stack.
cdef struct Refresh:
    const EntityStates* one
    Py_ssize_t rows
    const void* state
    const void* step
    const int32_t* delta_at
    void* moved


cdef void call_refresh(void* job) noexcept nogil:
    cdef Refresh* call = <Refresh*>job
    call.one.refresh(call.rows, call.state, call.step, call.delta_at, call.moved)


cdef double weighted_squares(
    const EntityStates* one, Py_ssize_t begin, Py_ssize_t end, const floating* state,
    const floating* values, const int64_t* at, const uint8_t* held, const int32_t* component,
    double* totals
) noexcept nogil:
    """Part of some rows in `StatePair.energy`; with components, added by component instead."""
    cdef Py_ssize_t row, u, k, first
    cdef const int32_t* use
    cdef const floating* x
    cdef double total = 0, size, whole
    for row in range(begin, end):
        first = one.delta_at[row]
        if first < 0:
            continue
        x = state + row * one.stride
        for u in range(one.use_count):
            use = one.uses + 4 * u
            whole = 1
            if use[1] != use[3]:
                for k in range(use[1]):
                    whole = max(whole, fabs(<double>x[use[0] + k]))
            for k in range(use[3]):
                if held[first + use[2] + k]:
                    continue
                if use[1] != use[3]:
                    size = whole
                else:
                    size = fabs(<double>x[use[0] + k])
                    if one.curved:
                        size = max(size, 1.0)
                total += <double>values[at[first + use[2] + k]] * size * size
        if component != NULL:
            totals[component[first]] += total
            total = 0
    return total


cdef void add_row_squares(
    const EntityStates* one, Py_ssize_t begin, Py_ssize_t end, const floating* state,
    const int32_t* component, double* totals
) noexcept nogil:
    """Part of some rows in `StatePair.add_squares`."""
    cdef Py_ssize_t row
    for row in range(begin, end):
        if one.delta_at[row] >= 0:
            totals[component[one.delta_at[row]]] += squares(
                state + row * one.stride, 1, one.stride, one.stored)


cdef class StatePair:
    """What the parameters are and what they are tried to be.

    Parameters
    ----------
    entities : sequence of Entity
    system : System
        Where each row's step begins.
    stored : list of arrays (rows, stored), one per entity, in the precision of the problem
    single : bool
    kernels : capsule "arael.kernels" or None
        Kernels of the first entities; those beyond are plain. Without, programs of the expression
        machine move the entities that are not plain.
    raised : Raised
        Where failures are kept.

    Attributes
    ----------
    arrays : list of two lists of arrays (rows, state), one per entity
    """

    def __init__(self, entities, system, stored, bint single, kernels, Raised raised):
        cdef EntityStates* one
        cdef const KernelTable* table = NULL
        if kernels is not None:
            table = table_of(kernels)
        dtype = np.dtype(np.float32 if single else np.float64)
        self.single, self._size, self._layout = single, system.size, entities
        self._raised = raised
        self._count = len(entities)
        self.arrays = [[], []]
        self._keep = [kernels]
        self._still = np.zeros(max(self._size, 1), dtype=dtype)
        self.entities = <EntityStates*>calloc(self._count + 1, sizeof(EntityStates))
        if self.entities == NULL:
            raise MemoryError
        for e, entity in enumerate(entities):
            one = &self.entities[<Py_ssize_t>e]
            rows = len(stored[e])
            for which in range(2):
                state = np.zeros((max(rows, 1), entity.state), dtype=dtype)
                state[:rows, : entity.stored] = stored[e]
                self.arrays[which].append(state)
                one.state[<int>which] = writable(state, dtype)
            one.rows = rows
            one.stored, one.stride, one.plain = entity.stored, entity.state, entity.plain
            uses = entity.places
            self._keep.append(uses)
            one.uses, one.use_count = <const int32_t*>address(uses, np.int32), len(uses)
            one.curved = entity.curved
            if table != NULL and e < table.entity_count:
                one.frame = refresh_frame_of(entity)
                one.refresh = table.refresh[<Py_ssize_t>e]
            elif not entity.plain:
                program = entity_program(entity)
                self._keep.append(program)
                one.program = <void*>program
        self.hold(system)
        for e in range(self._count):
            self._settle(e)
        raised.again()

    def hold(self, system):
        """Let the scalars move that move in a system of the same blocks.

        Both states must be the same in rows that do not move: `start_at` makes them so.
        """
        cdef EntityStates* one
        if system.size != self._size:
            raise ValueError(f"expected a system of {self._size} scalars, found {system.size}")
        self._first = []
        for e in range(self._count):
            one = &self.entities[<Py_ssize_t>e]
            blocks = system.blocks[e]
            # Rows in which nothing moves take no step, though a session may keep their blocks.
            first = blocks.first.astype(np.int32)
            some = blocks.every
            if not some:
                first[~blocks.solved] = -1
                some = blocks.solved.any()
            self._first.append(first)
            one.delta_at = <const int32_t*>address(first, np.int32, one.rows)
            one.moving = one.rows if some else 0
        self._still_scalars = np.zeros(max(self._size, 1), dtype=np.uint8)
        self._still_scalars[system.held] = 1
        self._held = <const uint8_t*>address(self._still_scalars, np.uint8)
        self.restrict()

    def restrict(self, component=None, kept=None):
        """Move rows of some components only; the others stay as they are accepted.

        Parameters
        ----------
        component : (n,) int32, component of each scalar of the system
        kept : (components,) bool, those whose rows move; None: all rows move
        """
        cdef Py_ssize_t e, rows, width
        runs, pieces = [], []
        self._large = False
        for e in range(self._count):
            rows, width = self.entities[e].moving, self.entities[e].stride
            if kept is None:
                # Cut by the problem alone, as all that threads share.
                parts = count_parts(rows * width)
                ends = [rows * k // parts for k in range(parts + 1)]
                mine = list(zip(ends, ends[1:])) if rows else []
            else:
                first = self._first[e][:rows]
                moves = first >= 0
                moves[moves] = kept[component[first[moves]]]
                kept_rows = self.arrays[self.current][e][:rows][~moves]
                self.arrays[1 - self.current][e][:rows][~moves] = kept_rows
                mine = rows_of(moves, ROW_GAP)
                parts = min(len(mine), count_parts(int(moves.sum()) * width))
            if len(mine):
                self._large |= parts > 1
                ends = [len(runs) + len(mine) * k // parts for k in range(parts + 1)]
                pieces += zip(ends, ends[1:])
            runs += [(e, begin, end) for begin, end in mine]
        self._moving = [
            np.array(runs, dtype=np.int64).reshape(-1, 3),
            np.array(pieces, dtype=np.int64).reshape(-1, 2),
        ]
        self._runs, self._run = len(runs), <const int64_t*>table_address(self._moving[0], 3)
        self._pieces, self._piece = len(pieces), <const int64_t*>table_address(self._moving[1], 2)

    def __dealloc__(self):
        free(self.entities)

    def start_at(self, Py_ssize_t e, stored):
        """Let the rows of an entity stand at other stored scalars (rows, stored)."""
        cdef Py_ssize_t rows = self.entities[e].rows, k, wide, stride
        cdef const char* from_
        cdef char* to
        for which in range(2):
            array = self.arrays[which][e]
            given = np.ascontiguousarray(stored, array.dtype)
            wide = self.entities[e].stored * <Py_ssize_t>array.itemsize
            stride = self.entities[e].stride * <Py_ssize_t>array.itemsize
            from_ = <const char*>address(given, array.dtype, rows * self.entities[e].stored)
            to = <char*>writable(array, array.dtype, rows * self.entities[e].stride)
            for k in range(rows):
                memcpy(to + k * stride, from_ + k * wide, wide)
        self._settle(e)
        self._raised.again()

    def _settle(self, Py_ssize_t e):
        """Caches of all rows of an entity from their stored scalars, without a step.

        In both states: rows that never move are not refreshed again.
        """
        cdef const void* still
        if self.entities[e].rows:
            still = address(self._still, self._still.dtype, self._size)
            with nogil:
                self._refresh_rows(e, 0, self.entities[e].rows, 0, 0, still)
                self._refresh_rows(e, 0, self.entities[e].rows, 0, 1, still)

    cdef void move(self, const void* step, int threads) noexcept nogil:
        cdef Move job
        job.states, job.step = <void*>self, step
        distribute(threads if self._large else 1, self._pieces, move_piece, &job)

    cdef void _move_piece(self, Py_ssize_t piece, const void* step) noexcept nogil:
        cdef Py_ssize_t k
        cdef const int64_t* run
        for k in range(self._piece[2 * piece], self._piece[2 * piece + 1]):
            run = self._run + 3 * k
            self._refresh_rows(run[0], run[1], run[2], self.current, 1 - self.current, step)

    cdef void accept(self) noexcept nogil:
        self.current = 1 - self.current

    cdef void accept_chosen(self, const uint8_t* chosen, const int32_t* component) noexcept nogil:
        cdef Py_ssize_t k, row, size, item = 4 if self.single else 8
        cdef const int64_t* run
        cdef EntityStates* one
        cdef char* kept
        cdef char* moved
        for k in range(self._runs):
            run = self._run + 3 * k
            one = &self.entities[run[0]]
            size = one.stride * item
            kept, moved = <char*>one.state[self.current], <char*>one.state[1 - self.current]
            for row in range(run[1], run[2]):
                # Rows that do not move are the same in both.
                if one.delta_at[row] >= 0 and not chosen[component[one.delta_at[row]]]:
                    memcpy(moved + row * size, kept + row * size, size)
        self.accept()

    cdef void* at(self, Py_ssize_t entity) noexcept nogil:
        return self.entities[entity].state[self.current]

    cdef double norm(self) noexcept nogil:
        cdef double total = 0
        cdef Py_ssize_t e
        cdef EntityStates* one
        for e in range(self._count):
            one = &self.entities[e]
            if self.single:
                total += squares(<const float*>self.at(e), one.moving, one.stride, one.stored)
            else:
                total += squares(<const double*>self.at(e), one.moving, one.stride, one.stored)
        return sqrt(total)

    cdef double energy(self, const void* values, const int64_t* diagonal_at) noexcept nogil:
        cdef double total = 0
        cdef Py_ssize_t e
        cdef EntityStates* one
        for e in range(self._count):
            one = &self.entities[e]
            if self.single:
                total += weighted_squares(
                    one, 0, one.rows, <const float*>self.at(e), <const float*>values, diagonal_at,
                    self._held, NULL, NULL)
            else:
                total += weighted_squares(
                    one, 0, one.rows, <const double*>self.at(e), <const double*>values, diagonal_at,
                    self._held, NULL, NULL)
        return total

    cdef void add_energy(
        self, const void* values, const int64_t* diagonal_at, const int32_t* component,
        double* total
    ) noexcept nogil:
        cdef Py_ssize_t k
        cdef const int64_t* run
        cdef EntityStates* one
        for k in range(self._runs):
            run = self._run + 3 * k
            one = &self.entities[run[0]]
            if self.single:
                weighted_squares(
                    one, run[1], run[2], <const float*>self.at(run[0]), <const float*>values,
                    diagonal_at, self._held, component, total)
            else:
                weighted_squares(
                    one, run[1], run[2], <const double*>self.at(run[0]), <const double*>values,
                    diagonal_at, self._held, component, total)

    cdef void add_squares(self, const int32_t* component, double* total) noexcept nogil:
        cdef Py_ssize_t k
        cdef const int64_t* run
        cdef EntityStates* one
        for k in range(self._runs):
            run = self._run + 3 * k
            one = &self.entities[run[0]]
            if self.single:
                add_row_squares(
                    one, run[1], run[2], <const float*>self.at(run[0]), component, total)
            else:
                add_row_squares(
                    one, run[1], run[2], <const double*>self.at(run[0]), component, total)

    cdef void _refresh_rows(
        self, Py_ssize_t e, Py_ssize_t begin, Py_ssize_t end, int source, int target,
        const void* step
    ) noexcept nogil:
        """New states of some rows, by addition, by the program or by the kernel."""
        cdef EntityStates* one = &self.entities[e]
        cdef Py_ssize_t offset = begin * one.stride * (4 if self.single else 8)
        cdef const int32_t* delta_at = one.delta_at + begin
        cdef const void* state = <char*>one.state[source] + offset
        cdef void* moved = <char*>one.state[target] + offset
        cdef Refresh job
        if one.program != NULL:
            if not (<TapeProgram>one.program).refresh(
                    self.single, one.stored, end - begin, state, step, delta_at, moved):
                with gil:
                    self._raised.keep(MemoryError("no memory for the registers of a step"))
        elif not one.plain:
            if stack_suffices(one.frame):
                one.refresh(end - begin, state, step, delta_at, moved)
                return
            job.one, job.rows, job.state, job.step = one, end - begin, state, step
            job.delta_at, job.moved = delta_at, moved
            if not stack_elsewhere(one.frame, call_refresh, &job):
                with gil:
                    self._raised.keep(MemoryError("no memory for the stack of a kernel"))
        elif self.single:
            add_step(end - begin, one.stride, <const float*>state, <const float*>step, delta_at,
                     <float*>moved)
        else:
            add_step(end - begin, one.stride, <const double*>state, <const double*>step, delta_at,
                     <double*>moved)


cdef void move_piece(void* job, Py_ssize_t piece) noexcept nogil:
    (<StatePair>(<Move*>job).states)._move_piece(piece, (<Move*>job).step)


def rows_of(kept, gap):
    """(m, 2) begin and end of runs of kept rows, those no further than `gap` apart as one."""
    rows = np.flatnonzero(kept)
    if not len(rows):
        return np.zeros((0, 2), dtype=np.int64)
    first = np.flatnonzero(np.diff(rows, prepend=rows[0] - gap - 2) > gap + 1)
    last = np.append(first[1:], len(rows)) - 1
    return np.stack((rows[first], rows[last] + 1), axis=1)
