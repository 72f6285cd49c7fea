# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
"""The states of all entities twice over: as accepted, and as a step would have them."""

import numpy as np

from libc.math cimport sqrt
from libc.stdint cimport int32_t
from libc.stdlib cimport calloc, free

from cython cimport floating

from arael.runtime.address cimport address
from arael.runtime.kernel cimport KernelTable, table_of
from arael.runtime.raised cimport Raised

from arael.runtime.interpreter import refresh


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
        Kernels of the first entities; those beyond are plain.
    raised : Raised
        Where failures of the interpreter are kept.

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
                one.state[<int>which] = <void*>address(state)
            first = np.ascontiguousarray(system.blocks[e].first, dtype=np.int32)
            self._keep.append(first)
            one.delta_at = <const int32_t*>address(first)
            one.rows, one.moving = rows, rows if (first >= 0).any() else 0
            one.stored, one.stride, one.plain = entity.stored, entity.state, entity.plain
            if table != NULL and e < table.entity_count:
                one.refresh = table.refresh[<Py_ssize_t>e]
        for e in range(self._count):
            self._settle(e)
        raised.again()

    def __dealloc__(self):
        free(self.entities)

    def start_at(self, Py_ssize_t e, stored):
        """Let the rows of an entity stand at other stored scalars (rows, stored)."""
        cdef Py_ssize_t rows = self.entities[e].rows, width = self.entities[e].stored
        for which in range(2):
            self.arrays[which][e][:rows, :width] = stored
        self._settle(e)
        self._raised.again()

    def _settle(self, Py_ssize_t e):
        """Caches of all rows of an entity from their stored scalars, without a step.

        In both states: rows that never move are not refreshed again.
        """
        if self.entities[e].rows:
            self._refresh(e, 0, 0, address(self._still))
            self._refresh(e, 0, 1, address(self._still))

    cdef void move(self, const void* step) noexcept nogil:
        cdef Py_ssize_t e
        for e in range(self._count):
            if self.entities[e].moving:
                self._refresh(e, self.current, 1 - self.current, step)

    cdef void accept(self) noexcept nogil:
        self.current = 1 - self.current

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

    cdef void _refresh(self, Py_ssize_t e, int source, int target, const void* step) noexcept nogil:
        cdef EntityStates* one = &self.entities[e]
        cdef void* state = one.state[source]
        cdef void* moved = one.state[target]
        if one.plain and self.single:
            add_step(one.rows, one.stride, <const float*>state, <const float*>step, one.delta_at,
                     <float*>moved)
        elif one.plain:
            add_step(one.rows, one.stride, <const double*>state, <const double*>step, one.delta_at,
                     <double*>moved)
        elif one.refresh != NULL:
            one.refresh(one.rows, state, step, one.delta_at, moved)
        else:
            with gil:
                try:
                    self._interpret(e, source, target, step)
                except BaseException as error:
                    self._raised.keep(error)

    cdef _interpret(self, Py_ssize_t e, int source, int target, const void* step):
        cdef Py_ssize_t rows = self.entities[e].rows
        entity = self._layout[e]
        state, moved = self.arrays[source][e][:rows], self.arrays[target][e][:rows]
        first = np.asarray(<const int32_t[:rows]>self.entities[e].delta_at)
        steps = np.zeros((rows, entity.tangent), dtype=state.dtype)
        moves = first >= 0
        if moves.any():
            if self.single:
                delta = np.asarray(<float[:self._size]><float*>step)
            else:
                delta = np.asarray(<double[:self._size]><double*>step)
            steps[moves] = delta[first[moves, None] + np.arange(entity.tangent)]
        refresh(entity, state, steps, moved)
