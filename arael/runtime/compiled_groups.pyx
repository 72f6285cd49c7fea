# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True
"""What runs each group without Python: a kernel, or a program of the expression machine."""

from libc.stdlib cimport calloc, free

from arael.runtime.kernel cimport KERNEL_ABI, KernelTable, Lanes, table_of
from arael.runtime.machine cimport Program

from arael.runtime.group_kernel import GroupKernel
from arael.runtime.machine import WIDTH
from arael.runtime.tape import NATIVE


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
            one.width = 1
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
            one.free = not self.missing(g) and not calls_natives(layout.groups[g])
        self.widths = [self._groups[g].width for g in range(len(programs))]
        self.free = [self.sharable(g) for g in range(len(programs))]
        self.stores = [self._groups[g].kernel != NULL for g in range(len(programs))]

    def __dealloc__(self):
        free(self._groups)

    cdef bint missing(self, Py_ssize_t g) noexcept nogil:
        return self._groups[g].program == NULL and self._groups[g].kernel == NULL

    cdef bint sharable(self, Py_ssize_t g) noexcept nogil:
        return self._groups[g].free

    cdef double cost(self, Py_ssize_t g, const Lanes* lanes) noexcept nogil:
        cdef Compiled* one = &self._groups[g]
        if lanes.n == 0:
            return 0
        if one.program != NULL:
            return (<Program>one.program).cost(lanes, &self.exhausted)
        return one.kernel.cost(lanes)

    cdef double linearise(
        self, Py_ssize_t g, const Lanes* lanes, void* gradient, void* values
    ) noexcept nogil:
        cdef Compiled* one = &self._groups[g]
        if lanes.n == 0:
            return 0
        if one.program != NULL:
            return (<Program>one.program).linearise(
                lanes, one.shared, gradient, values, &self.exhausted)
        return one.kernel.linearise(lanes, gradient, values)

    cdef bint guards(self, Py_ssize_t g) noexcept nogil:
        return self._groups[g].kernel != NULL and self._groups[g].kernel.guard != NULL

    cdef void guard(self, Py_ssize_t g, const Lanes* lanes) noexcept nogil:
        if lanes.n and self.guards(g):
            self._groups[g].kernel.guard(lanes)

    cdef void rows(
        self, Py_ssize_t g, const Lanes* lanes, void* residuals, void* entries
    ) noexcept nogil:
        cdef Compiled* one = &self._groups[g]
        if lanes.n == 0:
            return
        if one.program != NULL:
            (<Program>one.program).rows(lanes, residuals, entries, &self.exhausted)
        else:
            one.kernel.rows(lanes, residuals, entries)


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


def calls_natives(group):
    """Whether a group calls native functions, which may not bear being called side by side."""
    tapes = [group.tape] if group.moving_guard is None else [group.tape, group.moving_guard]
    return any(op.startswith(NATIVE) for tape in tapes for op in tape.ops)
