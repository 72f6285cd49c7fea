"""What runs each group without Python: a kernel, or a program of the expression machine."""

from libc.stdlib cimport calloc, free

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


cdef void call_rows(void* job) noexcept nogil:
    cdef Call* call = <Call*>job
    call.kernel.rows(call.lanes, call.first, call.second)


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
        if kernels is not None:
            require_own(layout, kernels, sum(program is None for program in programs))
            table = table_of(kernels)
        self._keep = (kernels, programs)
        self._groups = <Compiled*>calloc(len(programs) + 1, sizeof(Compiled))
        if self._groups == NULL:
            raise MemoryError
        for g, program in enumerate(programs):
            one = &self._groups[<Py_ssize_t>g]
            one.frame = frame_of(layout.groups[g], layout.entities)
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
            one.free = not layout.groups[g].calls_natives
        self.widths = [self._groups[g].width for g in range(len(programs))]
        self.free = [self.sharable(g) for g in range(len(programs))]
        self.stores = [self._groups[g].kernel != NULL for g in range(len(programs))]

    def __dealloc__(self):
        free(self._groups)

    cdef bint sharable(self, Py_ssize_t g) noexcept nogil:
        return self._groups[g].free

    cdef double cost(self, Py_ssize_t g, const Lanes* lanes, double* costs) noexcept nogil:
        cdef Compiled* one = &self._groups[g]
        if lanes.n == 0:
            return 0
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
