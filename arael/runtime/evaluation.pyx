# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
"""Cost, gradient and blocks of a problem, with the GIL taken only for what has no kernel."""

import numpy as np

from cpython.buffer cimport PyBUF_SIMPLE, PyBuffer_Release, PyObject_GetBuffer
from cpython.pycapsule cimport PyCapsule_GetPointer, PyCapsule_IsValid
from libc.math cimport NAN, sqrt
from libc.stdint cimport int32_t, int64_t, uint8_t
from libc.stdlib cimport calloc, free
from libc.string cimport memset

from cython cimport floating

from arael.runtime.kernel cimport KERNEL_ABI, Kernel, KernelTable, Lanes
from arael.runtime.machine cimport Program
from arael.runtime.pool cimport Task, distribute

from arael.runtime.group_kernel import GroupKernel
from arael.runtime.instances import in_lanes
from arael.runtime.machine import WIDTH
from arael.runtime.interpreter import GroupInterpreter, refresh
from arael.runtime.shares import SHARES, plan_shares
from arael.runtime.tape import NATIVE

cdef enum:
    MOST_SHARES = 8

assert SHARES <= MOST_SHARES


cdef const void* address(array) except? NULL:
    """First byte of a contiguous array."""
    cdef Py_buffer view
    # Ten times as fast as `array.ctypes.data`: there are many arrays, and most are small.
    PyObject_GetBuffer(array, &view, PyBUF_SIMPLE)
    cdef const void* found = view.buf
    PyBuffer_Release(&view)
    return found


cdef const KernelTable* table_of(capsule) except NULL:
    """The kernels in a capsule of a generated module."""
    if not PyCapsule_IsValid(capsule, "arael.kernels"):
        raise TypeError(f"expected a capsule `arael.kernels`, found {type(capsule).__name__}")
    return <const KernelTable*>PyCapsule_GetPointer(capsule, "arael.kernels")


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


cdef void clear(char* memory, Py_ssize_t size, Py_ssize_t part, Py_ssize_t parts) noexcept nogil:
    """Zero one of several parts of some bytes, cut at cache lines."""
    cdef Py_ssize_t lines = (size + 63) // 64
    cdef Py_ssize_t begin = min(size, lines * part // parts * 64)
    cdef Py_ssize_t end = min(size, lines * (part + 1) // parts * 64)
    memset(memory + begin, 0, end - begin)


cdef void add_places(
    const int64_t* sums, Py_ssize_t begin, Py_ssize_t end, floating* x
) noexcept nogil:
    """Add what shares have in places of their own to where it belongs, and empty those."""
    cdef Py_ssize_t k, i
    cdef floating *target
    cdef floating *source
    for k in range(begin, end):
        target, source = x + sums[3 * k], x + sums[3 * k + 1]
        for i in range(sums[3 * k + 2]):
            target[i] += source[i]
            source[i] = 0


cdef void cost_of_share(void* job, Py_ssize_t share) noexcept nogil:
    cdef Work* work = <Work*>job
    cdef double total = 0
    cdef Py_ssize_t g
    for g in range((<Evaluation>work.evaluation)._group_count):
        if (<Evaluation>work.evaluation)._free[g]:
            total += (<Evaluation>work.evaluation)._part_cost(g, share, work.which)
    work.totals[share] = total


cdef void guard_share(void* job, Py_ssize_t share) noexcept nogil:
    cdef Work* work = <Work*>job
    cdef Py_ssize_t g
    for g in range((<Evaluation>work.evaluation)._group_count):
        if (<Evaluation>work.evaluation)._free[g]:
            (<Evaluation>work.evaluation)._part_guard(g, share)


cdef void clear_share(void* job, Py_ssize_t share) noexcept nogil:
    cdef Work* work = <Work*>job
    cdef Py_ssize_t item = 4 if (<Evaluation>work.evaluation).single else 8
    cdef Py_ssize_t shares = (<Evaluation>work.evaluation).shares
    clear(<char*>work.gradient, (<Evaluation>work.evaluation)._gradient_room * item, share, shares)
    clear(<char*>work.values, (<Evaluation>work.evaluation)._value_room * item, share, shares)


cdef void linearise_share(void* job, Py_ssize_t share) noexcept nogil:
    cdef Work* work = <Work*>job
    cdef double total = 0
    cdef Py_ssize_t g
    for g in range((<Evaluation>work.evaluation)._group_count):
        if (<Evaluation>work.evaluation)._free[g]:
            total += (<Evaluation>work.evaluation)._part_linearise(
                g, share, work.gradient, work.values)
    work.totals[share] = total


cdef void sum_share(void* job, Py_ssize_t share) noexcept nogil:
    cdef Work* work = <Work*>job
    cdef const int64_t* g = (<Evaluation>work.evaluation)._gradient_ends + share
    cdef const int64_t* v = (<Evaluation>work.evaluation)._value_ends + share
    if (<Evaluation>work.evaluation).single:
        add_places((<Evaluation>work.evaluation)._gradient_sums, g[0], g[1], <float*>work.gradient)
        add_places((<Evaluation>work.evaluation)._value_sums, v[0], v[1], <float*>work.values)
    else:
        add_places((<Evaluation>work.evaluation)._gradient_sums, g[0], g[1], <double*>work.gradient)
        add_places((<Evaluation>work.evaluation)._value_sums, v[0], v[1], <double*>work.values)


def _ends(sums, count):
    """Rows at which equal parts of the sums begin and end, those of one target together."""
    ends = np.arange(count + 1) * len(sums) // count
    first = np.flatnonzero(np.diff(sums[:, 0], prepend=-1))
    ends = np.append(first, len(sums))[np.searchsorted(first, ends)]
    ends[0] = 0
    return ends


def is_plain(entity):
    """Whether all that a row holds is reals that a step is added to."""
    return not entity.updated and entity.stored == entity.tangent == entity.state and all(
        use.kind in ("real", "vec") for use in entity.params
    )


class Interpreters:
    """The NumPy interpreters of all groups, each made when it is first asked for."""

    def __init__(self, layout, instances, placements, dtype, natives):
        self._parts = layout, list(instances), placements, dtype, natives
        self._made = {}

    def __getitem__(self, g):
        if g not in self._made:
            layout, instances, placements, dtype, natives = self._parts
            self._made[g] = GroupInterpreter(
                layout.groups[g], layout.entities, instances[g], placements[g], dtype, natives
            )
        return self._made[g]

    def replace(self, g, one):
        """Take other data of a group."""
        self._parts[1][g] = one
        self._made.pop(g, None)


cdef class Evaluation:
    """What the Levenberg-Marquardt loop asks of a problem.

    Parameters
    ----------
    layout : Layout
    structure : Structure
    instances : list of Instances, one per group
    stored : list of arrays (rows, stored), one per entity, in the precision of the problem
    held_values, diagonal_at : int64 arrays, offsets in the values
    kernels : capsule "arael.kernels" or None
        None interprets what has no program.
    natives : NativeTable
        The native functions of the model.
    programs : list of machine.Program, GroupKernel or None, one per group
        What runs on the expression machine, or on kernels of its own. The compiled kernels of the
        model, if any, are of the groups before the first of these, and of the first entities.
    """

    def __init__(
        self, layout, structure, instances, stored, held_values, diagonal_at, kernels, natives,
        programs=None
    ):
        dtype = np.dtype(np.float32 if layout.precision == "f32" else np.float64)
        self.single = layout.precision == "f32"
        self.size = structure.system.size
        self.value_count = structure.pattern.value_count
        self.trash = structure.trash
        self._keep = [kernels]
        self.natives = natives
        self._entities = layout.entities
        self._groups = layout.groups
        self._group_count = len(layout.groups)
        self.guarded = any(group.moving_guard is not None for group in layout.groups)
        self._lane_data = []
        self._entity_count = len(layout.entities)
        self._programs = [None] * self._group_count if programs is None else list(programs)
        self._take_table(kernels)
        self._allocate(sum(len(g.uses) for g in layout.groups))
        self._take_kernels()
        self._make_states(layout.entities, structure.system, stored, dtype)
        self.threads = 1
        self._make_lanes(layout, structure, instances)
        self.interpreters = Interpreters(layout, instances, structure.placements, dtype, natives)
        held = self._kept(structure.system.held, np.int64)
        positions = self._kept(held_values, np.int64)
        self._held, self._held_count = <const int64_t*>address(held), len(held)
        self._held_values = <const int64_t*>address(positions)
        self._held_value_count = len(positions)
        self.diagonal_at = <const int64_t*>address(self._kept(diagonal_at, np.int64))
        self._still = np.zeros(max(self.size, 1), dtype=dtype)
        for e in range(self._entity_count):
            self._refresh_still(e)
        if self.failed:
            raise self.failure

    def __dealloc__(self):
        free(self._lanes[0])
        free(self._lanes[1])
        free(self._parts[0])
        free(self._parts[1])
        free(self._free)
        free(self._pointers)
        free(self._state[0])
        free(self._state[1])
        free(self._delta_at)
        free(self._rows)
        free(self._moving)
        free(self._stored)
        free(self._stride)
        free(self._plain)
        free(self._program)
        free(self._kernel)
        free(self._shared)
        free(self._width)

    # --- construction ------------------------------------------------------------------------

    cdef _take_table(self, kernels):
        self._table = NULL
        if kernels is None:
            return
        self._table = table_of(kernels)
        found = (self._table.abi, bool(self._table.single), self._table.group_count,
                 self._table.entity_count)
        groups = sum(program is None for program in self._programs)
        # Entities beyond those of the kernels are plain: reals that are added to.
        entities = min(self._entity_count, self._table.entity_count)
        expected = (KERNEL_ABI, bool(self.single), groups, entities)
        plain = all(map(is_plain, self._entities[entities:]))
        if found != expected or not plain:
            raise ValueError(
                f"these kernels do not belong to this model: (abi, single, groups, entities) "
                f"expected {expected}, found {found}"
            )

    cdef _take_kernels(self):
        """The kernel of each group that has one, and the lanes that its data is laid out for."""
        cdef const KernelTable* table
        cdef Py_ssize_t g
        for g, program in enumerate(self._programs):
            self._width[g] = 1
            if isinstance(program, Program):
                self._program[g] = <void*>program
                self._width[g] = WIDTH
            elif isinstance(program, GroupKernel):
                table = table_of(program.capsule)
                if (table.abi != KERNEL_ABI or bool(table.single) != bool(self.single)
                        or program.number >= table.group_count):
                    raise ValueError(f"`{self._groups[g].label}` has kernels of another model")
                self._keep.append(program)
                self._kernel[g] = &table.groups[<Py_ssize_t>program.number]
                self._width[g] = table.lanes
            elif self._table != NULL:
                self._kernel[g] = &self._table.groups[g]
                self._width[g] = self._table.lanes

    cdef _allocate(self, Py_ssize_t uses):
        cdef Py_ssize_t groups = self._group_count + 1, entities = self._entity_count + 1
        self._lanes[0] = <Lanes*>calloc(groups, sizeof(Lanes))
        self._lanes[1] = <Lanes*>calloc(groups, sizeof(Lanes))
        self._parts[0] = <Lanes*>calloc(groups * MOST_SHARES, sizeof(Lanes))
        self._parts[1] = <Lanes*>calloc(groups * MOST_SHARES, sizeof(Lanes))
        self._free = <uint8_t*>calloc(groups, 1)
        self._pointers = <const void**>calloc(2 * uses + 1, sizeof(void*))
        self._state[0] = <void**>calloc(entities, sizeof(void*))
        self._state[1] = <void**>calloc(entities, sizeof(void*))
        self._delta_at = <const int32_t**>calloc(entities, sizeof(void*))
        self._rows = <Py_ssize_t*>calloc(entities, sizeof(Py_ssize_t))
        self._moving = <Py_ssize_t*>calloc(entities, sizeof(Py_ssize_t))
        self._stored = <Py_ssize_t*>calloc(entities, sizeof(Py_ssize_t))
        self._stride = <Py_ssize_t*>calloc(entities, sizeof(Py_ssize_t))
        self._plain = <uint8_t*>calloc(entities, 1)
        self._width = <Py_ssize_t*>calloc(groups, sizeof(Py_ssize_t))
        self._program = <void**>calloc(groups, sizeof(void*))
        self._kernel = <const Kernel**>calloc(groups, sizeof(void*))
        self._shared = <uint8_t*>calloc(groups, 1)
        if not (self._lanes[0] and self._lanes[1] and self._parts[0] and self._parts[1]
                and self._free and self._pointers and self._state[0]
                and self._state[1] and self._delta_at and self._rows and self._moving
                and self._stored and self._stride and self._plain and self._program and self._kernel
                and self._shared and self._width):
            raise MemoryError

    cdef _kept(self, array, dtype):
        """The array as contiguous memory that lives as long as this object; never empty."""
        kept = np.ascontiguousarray(array, dtype=dtype)
        self._keep.append(kept)
        return kept

    cdef _make_states(self, entities, system, stored, dtype):
        self.states = [[], []]
        for e, entity in enumerate(entities):
            rows = len(stored[e])
            for which in range(2):
                state = np.zeros((max(rows, 1), entity.state), dtype=dtype)
                state[:rows, : entity.stored] = stored[e]
                self.states[which].append(state)
                self._state[which][e] = <void*>address(state)
            self._rows[e] = rows
            self._moving[e] = rows if (system.blocks[e].first >= 0).any() else 0
            self._stored[e] = entity.stored
            self._stride[e] = entity.state
            self._plain[e] = is_plain(entity)
            first = self._kept(system.blocks[e].first, np.int32)
            self._delta_at[e] = <const int32_t*>address(first)

    cdef _make_lanes(self, layout, structure, instances):
        cdef Py_ssize_t use = 0, which, u
        cdef Lanes* lanes
        groups, placements = layout.groups, structure.placements
        widths = [self._width[g] for g in range(self._group_count)]
        may = tuple(self._threads_may(layout, g) for g in range(self._group_count))
        key = (tuple(widths), may)
        if key not in structure.shares:
            structure.shares[key] = plan_shares(structure, groups, widths, may)
        plan = structure.shares[key]
        self.shares, self._bounds = plan.count, plan.bounds
        self._gradient_room, self._value_room = plan.gradient_room, plan.value_room
        self._take_sums(plan)
        for g, (group, placement, one) in enumerate(
            zip(groups, placements, instances, strict=True)
        ):
            self._free[g] = may[g]
            if self._program[g] != NULL:
                self._shared[g] = bool((placement.rows == placement.rows[:1]).all())
            parts = plan.placed[g]
            self._keep.append(parts)
            self._lane_data.append(None)
            self._place_data(g, one)
            for which in range(2):
                lanes = &self._lanes[which][g]
                lanes.natives = self.natives.items
                lanes.row = <const int32_t*>address(parts[0])
                lanes.gradient_at = <const int32_t*>address(parts[1])
                lanes.block_at = <const int64_t*>address(parts[2])
                lanes.turn = <const uint8_t*>address(parts[3])
                lanes.state = &self._pointers[use]
                for u in range(len(group.uses)):
                    self._pointers[use] = self._state[which][<Py_ssize_t>group.uses[u].entity]
                    use += 1
            self._make_parts(g)

    def _threads_may(self, layout, g):
        """Whether a group runs without Python; native functions may not be called side by side."""
        group = layout.groups[g]
        tapes = [group.tape] if group.moving_guard is None else [group.tape, group.moving_guard]
        if any(op.startswith(NATIVE) for tape in tapes for op in tape.ops):
            return False
        return self._program[<Py_ssize_t>g] != NULL or self._kernel[<Py_ssize_t>g] != NULL

    cdef _make_parts(self, Py_ssize_t g):
        """The lanes of a group's shares: the same arrays from each share's first block on."""
        cdef Py_ssize_t which, share, begin, end, width = self._width[g]
        cdef Py_ssize_t data = self._lane_data[g][0].strides[0]
        cdef Py_ssize_t uses = len(self._groups[g].uses), pairs = uses * (uses + 1) // 2
        cdef Lanes* part
        bounds = self._bounds[g]
        for which in range(2):
            for share in range(self.shares):
                begin, end = bounds[share], bounds[share + 1]
                part = &self._parts[which][g * MOST_SHARES + share]
                part[0] = self._lanes[which][g]
                part.n = min(part.n, end * width) - min(part.n, begin * width)
                part.data = <const char*>part.data + begin * data
                part.row += begin * uses * width
                part.gradient_at += begin * uses * width
                part.block_at += begin * pairs * width
                part.turn += begin * pairs * width

    cdef _take_sums(self, plan):
        gradient = self._kept(plan.gradient_sums, np.int64)
        values = self._kept(plan.value_sums, np.int64)
        self._gradient_sums = <const int64_t*>address(gradient)
        self._value_sums = <const int64_t*>address(values)
        ends = self._kept(_ends(gradient, plan.count), np.int64)
        self._gradient_ends = <const int64_t*>address(ends)
        ends = self._kept(_ends(values, plan.count), np.int64)
        self._value_ends = <const int64_t*>address(ends)

    cdef _place_data(self, Py_ssize_t g, one):
        cdef Py_ssize_t width = self._width[g], which
        if width not in one.lanes:
            one.lanes[width] = in_lanes(one.data, width)
        parts = one.lanes[width], np.ascontiguousarray(one.uniform)
        self._lane_data[g] = parts
        for which in range(2):
            self._lanes[which][g].n = len(one.rows)
            self._lanes[which][g].data = address(parts[0])
            self._lanes[which][g].uniform = address(parts[1])

    # --- taking over what has changed since -----------------------------------------------------

    def replace(self, Py_ssize_t g, one):
        """Let the instances of a group have other data; there are as many as before."""
        if len(one.rows) != self._lanes[0][g].n:
            raise ValueError(f"expected {self._lanes[0][g].n} instances, found {len(one.rows)}")
        self._place_data(g, one)
        self._make_parts(g)
        self.interpreters.replace(g, one)

    def start_at(self, Py_ssize_t e, stored):
        """Let the rows of an entity stand at other stored scalars (rows, stored)."""
        cdef Py_ssize_t rows = self._rows[e], width = self._stored[e]
        for which in range(2):
            self.states[which][e][:rows, :width] = stored
        self._refresh_still(e)
        self.raise_failure()

    # --- the loop's face ---------------------------------------------------------------------

    cdef double cost(self, int which) noexcept nogil:
        cdef double totals[MOST_SHARES]
        cdef double total = 0
        cdef Py_ssize_t g, k
        cdef Work work
        if self.shares > 1:
            work.totals, work.which = totals, which
            self._run_shares(cost_of_share, &work)
            for k in range(self.shares):
                total += totals[k]
        for g in range(self._group_count):
            if self.shares == 1 or not self._free[g]:
                total += self._group_cost(g, which)
        return total

    cdef double _group_cost(self, Py_ssize_t g, int which) noexcept nogil:
        cdef Lanes* lanes = &self._lanes[which][g]
        if lanes.n == 0:
            return 0
        if self._program[g] != NULL:
            return self._checked((<Program>self._program[g]).cost(lanes))
        if self._kernel[g] != NULL:
            return self._checked(self._kernel[g].cost(lanes))
        with gil:
            try:
                return self.interpreters[g].cost(self.states[which])
            except BaseException as error:
                return self._fail(error)

    cdef double _part_cost(self, Py_ssize_t g, Py_ssize_t share, int which) noexcept nogil:
        cdef Lanes* lanes = &self._parts[which][g * MOST_SHARES + share]
        if lanes.n == 0:
            return 0
        if self._program[g] != NULL:
            return (<Program>self._program[g]).cost(lanes)
        return self._kernel[g].cost(lanes)

    cdef void _run_shares(self, Task task, Work* work) noexcept nogil:
        work.evaluation = <void*>self
        distribute(self.threads, self.shares, task, work)

    cdef void guard(self) noexcept nogil:
        cdef Py_ssize_t g
        cdef Work work
        if not self.guarded:
            return
        if self.shares > 1:
            self._run_shares(guard_share, &work)
        for g in range(self._group_count):
            if self.shares == 1 or not self._free[g]:
                self._whole_guard(g)

    cdef void _part_guard(self, Py_ssize_t g, Py_ssize_t share) noexcept nogil:
        cdef Lanes* lanes = &self._parts[self.current][g * MOST_SHARES + share]
        if lanes.n and self._kernel[g] != NULL and self._kernel[g].guard != NULL:
            self._kernel[g].guard(lanes)

    cdef void _whole_guard(self, Py_ssize_t g) noexcept nogil:
        cdef Lanes* lanes = &self._lanes[self.current][g]
        if lanes.n == 0 or self._program[g] != NULL:
            return
        if self._kernel[g] != NULL:
            if self._kernel[g].guard != NULL:
                self._kernel[g].guard(lanes)
            return
        with gil:
            try:
                self.interpreters[g].guard(self.states[self.current])
            except BaseException as error:
                self._fail(error)

    cdef double linearise(self, void* gradient, void* values) noexcept nogil:
        cdef size_t item = 4 if self.single else 8
        cdef double totals[MOST_SHARES]
        cdef double total = 0
        cdef Py_ssize_t g, k
        cdef Work work
        self.guard()
        work.gradient, work.values, work.totals = gradient, values, totals
        if self.shares == 1:
            memset(gradient, 0, self._gradient_room * item)
            memset(values, 0, self._value_room * item)
        else:
            self._run_shares(clear_share, &work)
            self._run_shares(linearise_share, &work)
            self._run_shares(sum_share, &work)
            for k in range(self.shares):
                total += totals[k]
        for g in range(self._group_count):
            if self.shares == 1 or not self._free[g]:
                total += self._group_linearise(g, gradient, values)
        if self.single:
            self._hold(<float*>gradient, <float*>values)
        else:
            self._hold(<double*>gradient, <double*>values)
        return total

    cdef double _part_linearise(
        self, Py_ssize_t g, Py_ssize_t share, void* gradient, void* values
    ) noexcept nogil:
        cdef Lanes* lanes = &self._parts[self.current][g * MOST_SHARES + share]
        if lanes.n == 0:
            return 0
        if self._program[g] != NULL:
            return (<Program>self._program[g]).linearise(lanes, self._shared[g], gradient, values)
        return self._kernel[g].linearise(lanes, gradient, values)

    cdef void _sum_shares(self, void* gradient, void* values) noexcept nogil:
        cdef Py_ssize_t k
        cdef Work work
        work.evaluation, work.gradient, work.values = <void*>self, gradient, values
        if self.shares > 1:
            for k in range(self.shares):
                sum_share(&work, k)

    cdef double _group_linearise(self, Py_ssize_t g, void* gradient, void* values) noexcept nogil:
        cdef Lanes* lanes = &self._lanes[self.current][g]
        if lanes.n == 0:
            return 0
        if self._program[g] != NULL:
            return self._checked(
                (<Program>self._program[g]).linearise(lanes, self._shared[g], gradient, values)
            )
        if self._kernel[g] != NULL:
            return self._checked(self._kernel[g].linearise(lanes, gradient, values))
        with gil:
            try:
                return self.interpreters[g].linearise(
                    self.states[self.current],
                    self._view(gradient, self._gradient_room),
                    self._view(values, self._value_room),
                )
            except BaseException as error:
                return self._fail(error)

    cdef void _hold(self, floating* gradient, floating* values) noexcept nogil:
        cdef Py_ssize_t k
        for k in range(self._held_value_count):
            values[self._held_values[k]] = 0
        for k in range(self._held_count):
            values[self.diagonal_at[self._held[k]]] = 1
            gradient[self._held[k]] = 0

    cdef void move(self, const void* step) noexcept nogil:
        cdef Py_ssize_t e
        cdef int other = 1 - self.current
        for e in range(self._entity_count):
            if self._moving[e]:
                self._refresh(e, self.current, other, step)

    cdef void accept(self) noexcept nogil:
        self.current = 1 - self.current

    cdef void* state(self, Py_ssize_t entity) noexcept nogil:
        return self._state[self.current][entity]

    cdef double norm(self) noexcept nogil:
        cdef double total = 0
        cdef Py_ssize_t e
        for e in range(self._entity_count):
            if self.single:
                total += squares(<const float*>self.state(e), self._moving[e], self._stride[e],
                                 self._stored[e])
            else:
                total += squares(<const double*>self.state(e), self._moving[e], self._stride[e],
                                 self._stored[e])
        return sqrt(total)

    cdef void _refresh(self, Py_ssize_t e, int source, int target, const void* step) noexcept nogil:
        if self._plain[e]:
            if self.single:
                add_step[float](
                    self._rows[e], self._stride[e], <const float*>self._state[source][e],
                    <const float*>step, self._delta_at[e], <float*>self._state[target][e],
                )
            else:
                add_step[double](
                    self._rows[e], self._stride[e], <const double*>self._state[source][e],
                    <const double*>step, self._delta_at[e], <double*>self._state[target][e],
                )
            return
        if self._table != NULL and self._table.refresh[e] != NULL:
            self._table.refresh[e](
                self._rows[e], self._state[source][e], step, self._delta_at[e],
                self._state[target][e]
            )
            return
        with gil:
            try:
                self._interpret_refresh(e, source, target, step)
            except BaseException as error:
                self._fail(error)

    cdef _interpret_refresh(self, Py_ssize_t e, int source, int target, const void* step):
        cdef Py_ssize_t rows = self._rows[e]
        entity = self._entities[e]
        state, moved = self.states[source][e][:rows], self.states[target][e][:rows]
        first = np.asarray(<const int32_t[:rows]>self._delta_at[e])
        steps = np.zeros((rows, entity.tangent), dtype=state.dtype)
        moves = first >= 0
        if moves.any():
            delta = self._view(<void*>step, self.size)
            steps[moves] = delta[first[moves, None] + np.arange(entity.tangent)]
        refresh(entity, state, steps, moved)

    cdef _refresh_still(self, Py_ssize_t e):
        """Caches of all rows of an entity from their stored scalars, without a step.

        In both buffers: rows that never move are not refreshed again.
        """
        if self._rows[e]:
            self._refresh(e, 0, 0, address(self._still))
            self._refresh(e, 0, 1, address(self._still))

    cdef _view(self, void* data, Py_ssize_t length):
        if self.single:
            return np.asarray(<float[:length]>data)
        return np.asarray(<double[:length]>data)

    cdef double _fail(self, error) noexcept:
        if not self.failed:
            self.failed = True
            self.failure = error
        return NAN

    cdef double _checked(self, double cost) noexcept nogil:
        """`cost`; a failure of a native function becomes one of the evaluation."""
        if self.natives.failed:
            with gil:
                self._fail(self.natives.failure)
        return cost

    # --- the same from Python ----------------------------------------------------------------

    @property
    def dtype(self):
        """NumPy type of the scalars."""
        return np.dtype(np.float32 if self.single else np.float64)

    @property
    def state_arrays(self):
        """Accepted states, one array (rows, state) per entity."""
        return self.states[self.current]

    def group_cost(self, Py_ssize_t g):
        """Cost of one group at the accepted state."""
        self.guard()
        cost = self._group_cost(g, self.current)
        self.raise_failure()
        return cost

    def total_cost(self):
        """Cost at the accepted state."""
        self.guard()
        cost = self.cost(self.current)
        self.raise_failure()
        return cost

    def linearised(self):
        """Cost, J'r (size,) and the values of J'J (value_count,) at the accepted state."""
        gradient, values = self.room()
        cost = self.linearise(<void*>address(gradient), <void*>address(values))
        self.raise_failure()
        return cost, gradient[: self.size], values[: self.value_count]

    def group_linearised(self, Py_ssize_t g, gradient, values):
        """Cost of one group at the accepted state; its J'r and J'J are added to the arrays.

        `gradient` and `values` are as `room` makes them.
        """
        self.guard()
        cost = self._group_linearise(g, <void*>address(gradient), <void*>address(values))
        self._sum_shares(<void*>address(gradient), <void*>address(values))
        self.raise_failure()
        return cost

    def room(self):
        """Zeros for J'r and for the values of J'J, with what lies behind them."""
        return (
            np.zeros(self._gradient_room, dtype=self.dtype),
            np.zeros(self._value_room, dtype=self.dtype),
        )

    def group_rows(self, Py_ssize_t g):
        """Residuals (n, residuals) and Jacobian entries (n, entries) of one group."""
        group = self._groups[g]
        self.guard()
        cdef Lanes* lanes = &self._lanes[self.current][g]
        residuals = np.zeros((lanes.n, group.residuals), dtype=self.dtype)
        entries = np.zeros((lanes.n, len(group.jacobian)), dtype=self.dtype)
        if lanes.n == 0:
            return residuals, entries
        if self._program[g] != NULL:
            (<Program>self._program[g]).rows(
                lanes, <void*>address(residuals), <void*>address(entries)
            )
            self.natives.raise_failure()
            return residuals, entries
        if self._kernel[g] != NULL:
            self._kernel[g].rows(
                lanes, <void*>address(residuals), <void*>address(entries)
            )
            self.natives.raise_failure()
            return residuals, entries
        return self.interpreters[g].rows(self.states[self.current])

    def acting(self, Py_ssize_t g):
        """(n,) bool, which instances of one group act at the accepted state."""
        self.guard()
        self.raise_failure()
        interpreter = self.interpreters[g]
        if self._program[g] != NULL:
            return interpreter.acting
        if self._kernel[g] == NULL:
            return interpreter.acting
        if interpreter.group.moving_guard is None:
            return interpreter.acting
        flags = self._lane_data[g][0][:, -1, :].ravel()
        return flags[: len(interpreter.instances.rows)] != 0

    def moved_by(self, step):
        """Make the accepted state the one moved by `step` (size,)."""
        kept = np.ascontiguousarray(step, dtype=self.dtype)
        if kept.shape != (self.size,):
            raise ValueError(f"expected a step of shape ({self.size},), found {kept.shape}")
        self.move(address(kept))
        self.raise_failure()
        self.accept()

    def raise_failure(self):
        """Raise what the interpreter raised, if anything."""
        if self.failed:
            failure, self.failure, self.failed = self.failure, None, False
            self.natives.clear()
            raise failure
