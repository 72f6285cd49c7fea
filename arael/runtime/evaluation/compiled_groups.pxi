"""What runs each group without Python: a kernel, or a program of the expression machine."""

from cython cimport floating
from libc.math cimport NAN
from libc.stdlib cimport calloc, free

from arael.runtime.address cimport address, writable
from arael.runtime.kernel cimport KERNEL_ABI, KernelTable, Lanes, table_of
from arael.runtime.machine.compiled cimport Program

from arael.runtime.parallel.frames import frame_of
from arael.runtime.evaluation.group_kernel import GroupKernel
from arael.runtime.machine.compiled import WIDTH

# A call of a kernel that needs another stack.
cdef struct Call:
    const Kernel* kernel
    const Lanes* lanes
    void* first
    void* second
    double value


cdef void call_cost(void* job) noexcept nogil:
    cdef Call* call = <Call*>job
    call.value = call.kernel.cost(call.lanes, <double*>call.first)


cdef void call_linearise(void* job) noexcept nogil:
    cdef Call* call = <Call*>job
    call.value = call.kernel.linearise(call.lanes, call.first, call.second)


cdef void call_guard(void* job) noexcept nogil:
    cdef Call* call = <Call*>job
    call.kernel.guard(call.lanes)


cdef void call_arguments(void* job) noexcept nogil:
    cdef Call* call = <Call*>job
    call.kernel.arguments(call.lanes)


cdef void call_rows(void* job) noexcept nogil:
    cdef Call* call = <Call*>job
    call.kernel.rows(call.lanes, call.first, call.second)


cdef Py_ssize_t interval_of(
    const floating* starts, const int32_t* range, Py_ssize_t at, floating x
) noexcept nogil:
    """The last interval of an owner that begins at `x` or before; else its first.

    The search begins at the interval `at`, because arguments move little between evaluations.
    """
    cdef Py_ssize_t low = range[2 * at], high = range[2 * at + 1], step = 1, middle
    if x >= starts[at]:
        low = at
        while low + step < high and x >= starts[low + step]:
            low += step
            step *= 2
        high = min(high, low + step)
    else:
        high = at
        while high - step > low and x < starts[high - step]:
            high -= step
            step *= 2
        low = max(low, high - step)
    while high - low > 1:
        middle = (low + high) // 2
        if x >= starts[middle]:
            low = middle
        else:
            high = middle
    return low


cdef void look_up(
    const Table* table, const Lanes* lanes, Py_ssize_t columns, Py_ssize_t width, Py_ssize_t uses,
    int32_t* chosen, floating* _
) noexcept nogil:
    """Replace the arguments of a look-up by the records of the intervals that they lie in.

    Outside of the table, unless clamped, a record is NaN. So it is for an argument that is NaN.
    Where the rows have parameters, those of the interval are written into `chosen`, which is as
    `lanes.row`. If it is NULL the interval is that of the rows in the lanes.
    """
    cdef const floating* starts = <const floating*>table.starts
    cdef const floating* ends = <const floating*>table.ends
    cdef const floating* records = <const floating*>table.records
    cdef const floating* record
    cdef floating* data = <floating*>lanes.data
    cdef floating* lane
    cdef floating x
    cdef Py_ssize_t block, w, k, at, first, last
    cdef bint given = chosen == NULL and table.near_uses and table.centre >= 0
    for block in range((lanes.n + width - 1) // width):
        lane = data + (block * columns + table.first) * width
        for w in range(width):
            if block * width + w >= lanes.n:  # padding repeats the last instance
                for k in range(table.width + 1):
                    lane[k * width + w] = lane[k * width + w - 1]
                for k in range(table.near_uses if chosen != NULL else 0):
                    at = (block * uses + table.use[2 * k]) * width + w
                    chosen[at] = chosen[at - 1]
                continue
            x, at = lane[width + w], <Py_ssize_t>lane[w]
            if given:
                at = table.interval_of[lanes.row[(block * uses + table.centre) * width + w]]
            else:
                at = interval_of(starts, table.range, at, x)
            lane[w] = <floating>at
            for k in range(table.near_uses if chosen != NULL else 0):
                chosen[(block * uses + table.use[2 * k]) * width + w] = table.near[
                    at * table.order + table.use[2 * k + 1]]
            first, last = table.range[2 * at], table.range[2 * at + 1] - 1
            if x != x or (not table.clamp and (x < starts[first] or x > ends[last])):
                for k in range(table.width):
                    lane[(k + 1) * width + w] = NAN
                continue
            record = records + at * table.width
            for k in range(table.width):
                lane[(k + 1) * width + w] = record[k]


cdef class CompiledGroups:
    """Kernels and programs of all groups, as far as they have one.

    Parameters
    ----------
    layout : Layout
    placements : list of Placement, one per group
    kernels : capsule "arael.kernels" or None
        The compiled kernels of the model: of the groups before the first program, and of the first
        entities.
    programs : list of machine.Program, GroupKernel or None, one per group
        What runs on the expression machine, or on kernels of its own.

    Raises
    ------
    ValueError
        The kernels are those of another model.
    """

    def __init__(self, layout, placements, kernels, programs):
        cdef const KernelTable* table = NULL
        cdef const KernelTable* own
        cdef Compiled* one
        cdef bint single = layout.precision == "f32"
        self._single, self._tables = single, [None] * len(programs)
        if kernels is not None:
            require_own(layout, kernels, sum(program is None for program in programs))
            table = table_of(kernels)
        self._keep = (kernels, programs)
        self._groups = <Compiled*>calloc(len(programs) + 1, sizeof(Compiled))
        if self._groups == NULL:
            raise MemoryError
        self._count = len(programs)
        for g, program in enumerate(programs):
            one = &self._groups[<Py_ssize_t>g]
            one.frame = frame_of(layout.groups[g], layout.entities)
            one.data, one.uses = layout.groups[g].data_count, len(layout.groups[g].uses)
            if isinstance(program, Program):
                rows = placements[g].rows
                one.program, one.width = <void*>program, WIDTH
                one.shared = bool((rows == rows[:1]).all())
            elif isinstance(program, GroupKernel):
                own = table_of(program.capsule)
                if (own.abi != KERNEL_ABI or bool(own.single) != single
                        or program.number >= own.group_count):
                    raise ValueError(f"`{layout.groups[g].label}` has kernels of another model")
                one.kernel = &own.groups[<Py_ssize_t>program.number]
                one.width = own.lanes
            elif table != NULL:
                one.kernel, one.width = &table.groups[<Py_ssize_t>g], table.lanes
            else:
                raise ValueError(f"`{layout.groups[g].label}` has neither kernel nor program")
            one.required = bool(layout.groups[g].require)
            one.free = not (layout.groups[g].calls_natives or one.required)
        self.widths = [self._groups[g].width for g in range(len(programs))]
        self.free = [self.sharable(g) for g in range(len(programs))]
        self.stores = [
            self._groups[g].kernel != NULL and not self._groups[g].required
            for g in range(len(programs))
        ]

    def __dealloc__(self):
        cdef Py_ssize_t g
        for g in range(self._count):
            free(self._groups[g].tables)
        free(self._groups)

    def look_up_in(self, Py_ssize_t g, tables, rows):
        """Let the instances of a group look up in these tables: one for each of its look-ups.

        `rows` are those of all used entities in lane order.
        """
        cdef Compiled* one = &self._groups[g]
        cdef Table* item
        dtype = np.float32 if self._single else np.float64
        free(one.tables)
        one.look_ups = 0
        one.tables = <Table*>calloc(len(tables) + 1, sizeof(Table))
        if one.tables == NULL:
            raise MemoryError
        for k, table in enumerate(tables):
            item = &one.tables[<Py_ssize_t>k]
            intervals, width = table.records.shape
            item.first, item.clamp = table.first, table.clamp
            item.width, item.intervals = width, intervals
            item.records = address(table.records, dtype, intervals * width)
            item.starts = address(table.starts, dtype, intervals)
            item.ends = address(table.ends, dtype, intervals)
            item.range = <const int32_t*>address(table.ranges, np.int32, 2 * intervals)
            item.order, item.near_uses = table.near.shape[1], len(table.uses)
            item.near = <const int32_t*>address(table.near, np.int32, intervals * item.order)
            item.interval_of = <const int32_t*>address(table.interval_of, np.int32)
            item.use = <const int32_t*>address(table.uses, np.int32, 2 * item.near_uses)
            item.centre = -1 if table.centre < 0 else table.uses[table.centre, 0]
        one.rows, one.trial_rows, trial_rows = NULL, NULL, None
        if any(len(table.uses) for table in tables):
            trial_rows = rows.copy()
            one.rows = <const int32_t*>address(rows, np.int32)
            one.trial_rows = <int32_t*>writable(trial_rows, np.int32)
        one.look_ups, self._tables[g] = len(tables), (tables, rows, trial_rows)

    cdef void _look_up(self, Compiled* one, const Lanes* lanes, bint trial) noexcept nogil:
        """Look up at the arguments; `trial`: the lanes read rows that are chosen anew."""
        cdef Py_ssize_t k
        cdef int32_t* chosen = <int32_t*>lanes.row if trial else NULL
        if not (one.look_ups and lanes.n):
            return
        if one.program != NULL:
            (<Program>one.program).arguments(lanes, &self.exhausted)
        elif not stack_suffices(one.frame):
            self._elsewhere(one, call_arguments, lanes, NULL, NULL)
        else:
            one.kernel.arguments(lanes)
        for k in range(one.look_ups):
            if self._single:
                look_up[float](
                    &one.tables[k], lanes, one.data, one.width, one.uses, chosen, <float*>NULL)
            else:
                look_up[double](
                    &one.tables[k], lanes, one.data, one.width, one.uses, chosen, <double*>NULL)

    cdef bint sharable(self, Py_ssize_t g) noexcept nogil:
        return self._groups[g].free

    cdef bint required(self, Py_ssize_t g) noexcept nogil:
        return self._groups[g].required

    cdef double cost(self, Py_ssize_t g, const Lanes* lanes, double* costs) noexcept nogil:
        cdef Compiled* one = &self._groups[g]
        cdef Lanes trial
        if lanes.n == 0:
            return 0
        if one.trial_rows != NULL:
            trial = lanes[0]
            trial.row = one.trial_rows + (lanes.row - one.rows)
            lanes = &trial
        self._look_up(one, lanes, one.trial_rows != NULL)
        if one.program != NULL:
            return (<Program>one.program).cost(lanes, costs, &self.exhausted)
        if not stack_suffices(one.frame):
            return self._elsewhere(one, call_cost, lanes, costs, NULL)
        return one.kernel.cost(lanes, costs)

    cdef double linearise(
        self, Py_ssize_t g, const Lanes* lanes, void* gradient, void* values
    ) noexcept nogil:
        cdef Compiled* one = &self._groups[g]
        if lanes.n == 0:
            return 0
        self._look_up(one, lanes, False)
        if one.program != NULL:
            return (<Program>one.program).linearise(
                lanes, one.shared, gradient, values, &self.exhausted)
        if not stack_suffices(one.frame):
            return self._elsewhere(one, call_linearise, lanes, gradient, values)
        return one.kernel.linearise(lanes, gradient, values)

    cdef bint guards(self, Py_ssize_t g) noexcept nogil:
        cdef Compiled* one = &self._groups[g]
        if one.program != NULL:
            return (<Program>one.program).guarded
        return one.kernel.guard != NULL

    cdef void guard(self, Py_ssize_t g, const Lanes* lanes) noexcept nogil:
        cdef Compiled* one = &self._groups[g]
        if not (lanes.n and self.guards(g)):
            return
        self._look_up(one, lanes, False)
        if one.program != NULL:
            (<Program>one.program).guard(lanes, &self.exhausted)
        elif not stack_suffices(one.frame):
            self._elsewhere(one, call_guard, lanes, NULL, NULL)
        else:
            one.kernel.guard(lanes)

    cdef void rows(
        self, Py_ssize_t g, const Lanes* lanes, void* residuals, void* entries
    ) noexcept nogil:
        cdef Compiled* one = &self._groups[g]
        if lanes.n == 0:
            return
        self._look_up(one, lanes, False)
        if one.program != NULL:
            (<Program>one.program).rows(lanes, residuals, entries, &self.exhausted)
        elif not stack_suffices(one.frame):
            self._elsewhere(one, call_rows, lanes, residuals, entries)
        else:
            one.kernel.rows(lanes, residuals, entries)

    cdef double _elsewhere(
        self, Compiled* one, void (*call)(void*) noexcept nogil, const Lanes* lanes, void* first,
        void* second
    ) noexcept nogil:
        """Call a kernel on a stack that is large enough; threads of Python may have small ones."""
        cdef Call job
        job.kernel, job.lanes, job.first, job.second = one.kernel, lanes, first, second
        job.value = 0
        if not stack_elsewhere(one.frame, call, &job):
            self.exhausted = True
        return job.value


def require_own(layout, kernels, Py_ssize_t groups):
    """Raise unless the kernels are those of the first `groups` groups, and of the entities."""
    cdef const KernelTable* table = table_of(kernels)
    found = table.abi, bool(table.single), table.group_count, table.entity_count
    # Entities beyond those of the kernels are plain: reals that are added to.
    entities = min(len(layout.entities), found[3])
    expected = KERNEL_ABI, layout.precision == "f32", groups, entities
    if found != expected or not all(entity.plain for entity in layout.entities[entities:]):
        raise ValueError(
            f"these kernels do not belong to this model: (abi, single, groups, entities) "
            f"expected {expected}, found {found}"
        )
