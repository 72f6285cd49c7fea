"""The groups of a problem with all they read and add to, each evaluated by whatever can run it."""

import numpy as np

from arael.runtime.address cimport address
from arael.runtime.kernel cimport Lanes
from arael.runtime.assembly.compiled cimport Totals

from arael.runtime.assembly.scatter_plan import Execution
from arael.runtime.machine.programs import group_program


cdef class Groups:
    """One group at a time, at states that move.

    Parameters
    ----------
    layout : Layout
    structure : Structure
    instances : list of Instances, one per group
    stored : list of arrays (rows, stored), one per entity, in the precision of the problem
    held_values, diagonal_at : int64 arrays, offsets in the values
    kernels : capsule "arael.kernels" or None
        None: the expression machine runs all groups.
    natives : NativeTable
        The native functions of the model.
    programs : list of machine.Program, GroupKernel or None, one per group
        What runs on the expression machine, or on kernels of its own. The compiled kernels of the
        model, if any, are of the groups before the first of these, and of the first entities.
    hooks : Hooks, or None
        Functions of the caller that evaluate groups, and that are called before a linearisation.
    """

    def __init__(
        self, layout, structure, instances, stored, held_values, diagonal_at, kernels, natives,
        programs=None, hooks=None
    ):
        system, groups = structure.system, layout.groups
        self.single, self.size = layout.precision == "f32", system.size
        self.groups, self.count = groups, len(groups)
        self.raised = Raised(natives)
        programs = [None] * len(groups) if programs is None else list(programs)
        if kernels is None:
            programs = [
                one or group_program(layout, group)
                for one, group in zip(programs, groups, strict=True)
            ]
        self._made_of = layout, kernels, programs, natives
        self.states = StatePair(
            layout.entities, system, stored, self.single, kernels, self.raised)
        self.place(structure, instances, held_values, diagonal_at)
        self.hooks, self.hooked = hooks, hooks is not None
        if hooks is not None:
            hooks.attach(self.states, self.lanes.data, self.orders)

    def place(self, structure, instances, held_values, diagonal_at):
        """Take other instances, or others of their places, in a system of the same blocks.

        Parameters as those of the class; the states stay.
        """
        layout, kernels, programs, natives = self._made_of
        self.value_count = structure.pattern.value_count
        self.compiled = CompiledGroups(layout, structure.placements, kernels, programs)
        widths = self.compiled.widths
        plan = structure.plan.shares_for(
            Execution(tuple(widths), tuple(self.compiled.free), tuple(self.compiled.stores)))
        self.shares = plan.count
        self.orders = plan.orders
        self.lanes = GroupLanes(self.groups, instances, plan, widths, self.states, natives)
        for g, one in enumerate(instances):
            self.compiled.look_up_in(g, one.tables, self.lanes.rows_of(g))
        totals = Totals(plan, structure.system.held, held_values, diagonal_at, self.single)
        if self.totals is not None:
            totals.take_arrays(self.totals)
        self.totals = totals

    cdef double group_cost_at(self, Py_ssize_t g, int which) noexcept nogil:
        return self._checked(self.compiled.cost(g, self.lanes.whole(which, g), NULL))

    cdef void guard_group(self, Py_ssize_t g) noexcept nogil:
        self.compiled.guard(g, self.lanes.whole(self.states.current, g))

    cdef double linearise_group(
        self, Py_ssize_t g, const Lanes* lanes, void* gradient, void* values
    ) noexcept nogil:
        return self._checked(self.compiled.linearise(g, lanes, gradient, values))

    cdef double _checked(self, double value) noexcept nogil:
        """`value`; what went wrong in kernels and programs meanwhile is kept."""
        if self.compiled.exhausted:
            self.compiled.exhausted = False
            with gil:
                self.raised.keep(MemoryError(
                    "no memory for the registers of a program or the stack of a kernel"))
        return self.raised.checked(value)

    @property
    def dtype(self):
        """NumPy type of the scalars."""
        return np.dtype(np.float32 if self.single else np.float64)

    @property
    def state_arrays(self):
        """Accepted states, one array (rows, state) per entity."""
        return self.states.arrays[self.states.current]

    def replace(self, Py_ssize_t g, one):
        """Let the instances of a group have other data; there are as many as before."""
        self.lanes.replace(g, one)
        self.compiled.look_up_in(g, one.tables, self.lanes.rows_of(g))

    def hold(self, system, held_values):
        """Let the scalars move that move in a system of the same blocks.

        Every entity must start at stored scalars after this.
        """
        self.states.hold(system)
        self.totals.hold_others(system.held, held_values)

    def start_at(self, Py_ssize_t e, stored):
        """Let the rows of an entity stand at other stored scalars (rows, stored)."""
        self.states.start_at(e, stored)

    def moved_by(self, step):
        """Make the accepted state the one moved by `step` (size,)."""
        kept = np.ascontiguousarray(step, dtype=self.dtype)
        if kept.shape != (self.size,):
            raise ValueError(f"expected a step of shape ({self.size},), found {kept.shape}")
        cdef const void* first = address(kept, self.dtype, self.size)
        with nogil:
            self.states.move(first, 1)
        self.raise_failure()
        self.states.accept()

    def workspace(self):
        """Zeros for J'r and for the values of J'J, with what lies behind them."""
        return self.totals.zeros()

    def raise_failure(self):
        """Raise what a native function raised, if anything."""
        self.raised.again()
