"""A model instance made ready to be solved."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from arael.diagnostics.records import Diagnostic
from arael.runtime.assembly.positions import dense_matrix
from arael.runtime.assembly.structure import Structure, structure_of
from arael.runtime.bounds import check_start
from arael.runtime.evaluation.compiled import Evaluation
from arael.runtime.evaluation.hooks import Hooks
from arael.runtime.evaluation.instances import Instances, gather_instances
from arael.runtime.evaluation.states import put_values, solved_values, stored_scalars, write_back
from arael.runtime.evaluation.unbound import require_bound
from arael.runtime.evaluation.watch import Watch
from arael.runtime.failures import SolveError
from arael.runtime.layout import Layout
from arael.runtime.levenberg.compiled import Box
from arael.runtime.linear.compiled import LinearSolver
from arael.runtime.linear.small import small_solver
from arael.runtime.machine.compiled import NativeTable
from arael.runtime.machine.native_binding import Binding
from arael.runtime.machine.programs import evaluate
from arael.runtime.store.access import Array, Bools, Ints, StoreLike
from arael.runtime.system import blocks_of, row_name


class Problem:
    """Active instances, states and block pattern of one model instance at one time.

    Parameters
    ----------
    layout : the compiled model
    store : its data
    kernels : capsule ``arael.kernels`` of the generated module; None: the expression
        machine
    frozen : paths of parameters, or of what holds them, that do not move (``poses.ea``)
    known : structure of an earlier problem, taken over if nothing of it has changed
    programs : per group its `arael.runtime.machine.compiled.Program`, or None where kernels have it
    bindings : what is bound to the native functions of the model
    earlier : problem of the same model, from which all that has not changed is taken over
    keep_idle : whether parameters fixed since `earlier` may stay in the system, held (a session)
    structure : of chosen instances of the store; by default all that act

    Attributes
    ----------
    structure : active instances, system, pattern
    evaluation : cost, gradient and blocks; holds the state that moves
    seconds : spent on preparation
    gathered : groups whose data was gathered, when made or last refreshed
    upcoming : new structure found by `refresh`, for the next problem
    state_dirty : whether the accepted state may differ from the values in the store

    Raises
    ------
    SolveError
        E1005: an active constraint reads through a null ref; E1016: the sigma of a prior is not
        positive; E1017: a list is too long for a sum that is evaluated term by term.
    AraelError
        E0820: nothing is bound to a native function that a constraint calls.
    """

    evaluation_type: type[Evaluation] = Evaluation
    box_type: type[Box] = Box

    def __init__(
        self,
        layout: Layout,
        store: StoreLike,
        kernels: Any = None,
        *,
        frozen: frozenset[str] = frozenset(),
        known: Structure | None = None,
        programs: Sequence[Any] | None = None,
        bindings: Mapping[str, Binding] | None = None,
        earlier: Problem | None = None,
        keep_idle: bool = False,
        structure: Structure | None = None,
    ) -> None:
        began = time.perf_counter()
        if layout.summed:
            # Imported here for start-up time: only models with sums over rows need it.
            from arael.runtime.unrolled import unrolled

            layout, store, programs = unrolled(layout, store, programs)
        self.layout = layout
        self.store = store
        self.dtype = np.dtype(np.float32 if layout.precision == "f32" else np.float64)
        self.natives = NativeTable([f for f in layout.functions if f.native], bindings or {})
        require_bound(layout, self.natives)
        if known is None and earlier is not None:
            known = earlier.structure
        if keep_idle and earlier is not None:
            known = earlier.upcoming or known
        self.structure: Structure = structure or structure_of(
            store, frozen, known, self.natives, keep_idle
        )
        self.upcoming: Structure | None = None
        self.gathered = 0
        self._watch = Watch(layout)
        self.hooks = Hooks.of(store, self.structure)
        self.instances: list[Instances] = self._instances(earlier)
        self.diagonal_at = self.structure.plan.diagonal_at
        self.evaluation = self.evaluation_type(
            layout,
            self.structure,
            self.instances,
            [stored_scalars(store, entity, self.dtype) for entity in layout.entities],
            self.structure.plan.values_of(self.structure.system.held),
            self.diagonal_at,
            kernels,
            self.natives,
            programs,
            self.hooks,
        )
        self.box = self.box_type(self.evaluation, self.structure, self.diagonal_at)
        self._loaded = [store.tables[e.table].values_version for e in layout.entities]
        self.state_dirty = False
        self.number_instances()
        self.seconds = time.perf_counter() - began
        if keep_idle and earlier is not None and earlier.upcoming is not None:
            self.seconds += earlier.seconds

    def _instances(self, earlier: Problem | None) -> list[Instances]:
        """Data of all groups, gathered where `earlier` has other data or none."""
        layout = self.layout
        if earlier is not None and earlier.layout is layout and earlier.store is self.store:
            self._watch = earlier._watch.copy()
            changed = self._watch.changed(self.store)
            known = {
                number: one
                for number, one in enumerate(earlier.instances)
                if number not in changed and self._same_ways(number, earlier.structure)
            }
        else:
            self._watch.changed(self.store)
            known = {} if earlier is None else self._own_data(earlier)
        return [
            known[number]
            if number in known and not group.written and not self._hooked(number)
            else self._gather(number)
            for number, group in enumerate(layout.groups)
        ]

    def _hooked(self, number: int) -> bool:
        """Whether a function of the caller evaluates a group, so that its data is never shared."""
        return self.hooks is not None and number in self.hooks.items

    def _same_ways(self, number: int, before: Structure) -> bool:
        """Whether a group reads the rows that it read in an earlier structure."""
        now = self.structure
        if now.slot_rows is before.slot_rows:
            return True
        return np.array_equal(now.active[number], before.active[number]) and all(
            np.array_equal(rows, others)
            for rows, others in zip(now.slot_rows[number], before.slot_rows[number], strict=True)
        )

    def _own_data(self, earlier: Problem) -> dict[int, Instances]:
        """Data that `earlier` has of groups that read their own rows only, which are the same."""
        there: dict[str, list[int]] = {}
        for number, group in enumerate(earlier.layout.groups):
            there.setdefault(group.label, []).append(number)
        found = {}
        for number, group in enumerate(self.layout.groups):
            same = (
                k
                for k in there.get(group.label, ())
                if earlier.layout.groups[k].prepare is group.prepare
            )
            before = next(same, None)
            if (
                before is not None
                and not group.totals
                and all(not group.slots[raw.slot].steps for raw in group.raw)
                and self.store.tables[group.table] is earlier.store.tables.get(group.table)
                and self._watch.same_table(group.table, earlier._watch)
            ):
                found[number] = earlier.instances[before]
        return found

    def _gather(self, number: int) -> Instances:
        self.gathered += 1
        structure = self.structure
        group = self.layout.groups[number]
        if group.sigma is not None or any("sigma" in raw.column for raw in group.raw):
            # Imported here for start-up time: only what has a sigma from data is checked.
            from arael.runtime.evaluation.sigmas import check_sigmas

            check_sigmas(
                self.store,
                group,
                structure.active[number],
                structure.slot_rows[number],
                self.natives,
            )
        return gather_instances(
            self.store,
            group,
            structure.active[number],
            structure.slot_rows[number],
            self.dtype,
            self.natives,
        )

    def refresh(self, frozen: frozenset[str] = frozenset()) -> bool:
        """Start again from the current values of the store.

        Returns
        -------
        False, with nothing done, if other blocks or rows are solved for: it takes a new problem.
        """
        began = time.perf_counter()
        before = self.structure
        found = structure_of(self.store, frozen, before, self.natives, keep_idle=True)
        if found is not before and not self._fits(found):
            self.upcoming = found
            self.seconds = time.perf_counter() - began  # counted with the problem that takes it
            return False
        self.structure = found
        changed = self._watch.changed(self.store)
        if found.plan is not before.plan:
            changed.update(n for n in range(len(self.instances)) if not self._same_ways(n, before))
        self.gathered = 0
        for number in changed:
            self.instances[number] = self._gather(number)
        if found.plan is before.plan:
            for number in changed:
                self.evaluation.replace(number, self.instances[number])
        if found is not before:
            self._take_changes(before)
        self.load_values()
        self.number_instances()
        self.seconds = time.perf_counter() - began
        return True

    def _fits(self, found: Structure) -> bool:
        """Whether a structure has the blocks and rows of this problem, whose states then stay."""
        # Functions of the caller, and parts on other machines, keep arrays made from the structure.
        own = self.hooks is None and self.evaluation_type is Evaluation
        return (
            own
            and found.pattern is self.structure.pattern
            and all(
                now.first is then.first
                for now, then in zip(found.system.blocks, self.structure.system.blocks, strict=True)
            )
        )

    def _take_changes(self, before: Structure) -> None:
        """Let the evaluation have what is held and where instances add in the structure of now."""
        system, plan = self.structure.system, self.structure.plan
        held_values = plan.values_of(system.held)
        if plan is not before.plan:
            self.evaluation.place(self.structure, self.instances, held_values, self.diagonal_at)
        if system is not before.system:
            self.evaluation.hold(system, held_values)
            self.box = self.box_type(self.evaluation, self.structure, self.diagonal_at)
            self.state_dirty = True  # rows that move no longer must be the same in both states

    def load_values(self) -> None:
        """Start at the current values of the store; data and flags must be those of before."""
        if self.hooks is not None:
            self.hooks.restart()
        for number, entity in enumerate(self.layout.entities):
            version = self.store.tables[entity.table].values_version
            # An interrupted solve may have changed the state after its last write-back.
            if version is None or self.state_dirty or version != self._loaded[number]:
                values = stored_scalars(self.store, entity, self.dtype)
                self.evaluation.start_at(number, values)
                self._loaded[number] = version
        self.state_dirty = False

    @property
    def size(self) -> int:
        """Number of scalars of the system, those held in partly fixed entities included."""
        return self.structure.system.size

    @property
    def states(self) -> list[Array]:
        """Accepted states, one array (rows, state) per entity."""
        found: list[Array] = self.evaluation.state_arrays
        return found

    @property
    def x(self) -> Array:
        """Stored scalars of every entity row that is solved for, in order of the system, f64."""
        return solved_values(self.structure.system, self.states)

    def make_solver(self, name: str = "auto", **options: Any) -> LinearSolver:
        """A linear solver for this problem's pattern.

        ``eliminate`` may also name collections: ``"landmarks"``, or several of them; without it
        those that the model says to marginalize are eliminated, if it says so.
        """
        single = self.layout.precision == "f32"
        small = small_solver(name, self.structure.pattern, single, options)
        if small is not None:
            return small
        # Imported here for start-up time: a solve of a small problem does not load the analysis.
        from arael.runtime.linear.auto import make_solver

        if self.layout.marginalize and name in ("auto", "schur", "schur_pcg"):
            options.setdefault("eliminate", list(self.layout.marginalize))
        chosen = options.get("eliminate", "auto")
        names = [chosen] if isinstance(chosen, str) else list(chosen)
        if chosen != "auto" and all(isinstance(name, str) for name in names):
            options["eliminate"] = blocks_of(self.structure.system, names)
        solver: LinearSolver = make_solver(name, self.structure.pattern, single, **options)
        return solver

    def write_back(self) -> None:
        """Put the accepted state into the store."""
        write_back(self.store, self.structure.system, self.states)
        self._loaded = [self.store.tables[e.table].values_version for e in self.layout.entities]
        self.state_dirty = False

    def put(self, x: Array) -> None:
        """Put stored scalars, in the order of `x`, into the store; this problem stays as it is."""
        put_values(self.store, self.structure.system, x)

    @property
    def free(self) -> Ints:
        """Scalars of the system that move, ascending: all but those held."""
        moves = np.ones(self.size, dtype=bool)
        moves[self.structure.system.held] = False
        return np.flatnonzero(moves)

    def parameter_names(self) -> list[str]:
        """Name of every scalar that moves, in order."""
        names = self.structure.system.names()
        return [names[i] for i in self.free]

    def instance_name(self, group: int, instance: int) -> str:
        """Name of an instance of a constraint: ``PointFrine.bearing[17]``."""
        return f"{self.layout.groups[group].label}[{self.structure.active[group][instance]}]"

    def instance_place(self, group: int, instance: int) -> str:
        """The row that an instance acts on: ``landmarks[5].frines[2]``; of the root its name."""
        path = self.layout.groups[group].table
        row = int(self.structure.active[group][instance])
        return row_name(self.store, path, row) or self.layout.root

    def group_inputs(
        self, number: int, states: Sequence[Array], derivatives: bool = True
    ) -> list[Array]:
        """Inputs of the tape of a group, each (n,) or a scalar.

        Parameters
        ----------
        number : of the group
        states : one array (rows, state) per entity, in any precision; instances are active, and
            look-ups in the intervals, as at the accepted state
        derivatives : False leaves zeros for Jacobian entries that a function of the caller gives
        """
        group, one = self.layout.groups[number], self.instances[number]
        at = self.structure.placements[number].rows
        moving = [states[group.uses[u].entity][at[:, u], offset] for u, offset in group.states]
        data = list(one.data.T)
        if self.hooks is not None and number in self.hooks.items:
            found = self.hooks.columns_at(number, states, derivatives)
            data = [*found.T, *[np.zeros(len(found))] * (len(data) - found.shape[1])]
        for table, argument in zip(one.tables, self.arguments(number), strict=True):
            records = table.records_at(argument, at)
            data[table.first + 1 : table.first + 1 + len(records.T)] = records.T
        if group.moving_guard is not None:
            data[-1] = np.asarray(self.evaluation.acting(number), dtype=self.dtype)
        return [*moving, *data, *one.uniform]

    def arguments(self, number: int) -> list[Array]:
        """Arguments of the look-ups of a group at the accepted state, each (n,)."""
        group, one = self.layout.groups[number], self.instances[number]
        if group.arguments is None:
            return []
        at, states = self.structure.placements[number].rows, self.states
        moving = [states[group.uses[u].entity][at[:, u], offset] for u, offset in group.states]
        inputs = [*moving, *one.data.T, *one.uniform]
        found = evaluate(group.arguments, inputs, self.dtype, self.natives)
        return [np.broadcast_to(argument, len(one.rows)) for argument in found]

    def constraint_rows(self, number: int) -> tuple[Array, Bools, Ints]:
        """Residuals (n, m), whether they act, and rows of the instances of a constraint, in order.

        A constraint with sums over rows is evaluated by several groups (`arael.runtime.unrolled`).
        """
        groups = self.layout.groups
        cases = [number, *(k for k, group in enumerate(groups) if group.case_of == number)]
        residuals = [self.evaluation.group_rows(k)[0] for k in cases]
        acting = [np.asarray(self.evaluation.acting(k), dtype=bool) for k in cases]
        active = np.concatenate([self.structure.active[k] for k in cases])
        order = np.argsort(active, kind="stable")
        return (
            np.concatenate(residuals).astype(np.float64)[order],
            np.concatenate(acting)[order],
            active[order],
        )

    # --- dense views of the linearisation ----------------------------------------------------

    def cost(self) -> float:
        """Sum of squared residuals at the accepted state."""
        return float(self.evaluation.total_cost())

    def gradient(self) -> Array:
        """Gradient 2 J'r, f64, one entry per scalar that moves."""
        return 2.0 * np.asarray(self.evaluation.linearised()[1], dtype=np.float64)[self.free]

    def hessian(self) -> Array:
        """Gauss-Newton Hessian 2 J'J, f64, dense, over the scalars that move."""
        values = self.evaluation.linearised()[2]
        return 2.0 * dense_matrix(self.structure.pattern, values)[np.ix_(self.free, self.free)]

    def touched(self) -> Array:
        """(n,) bool, scalars that some active constraint depends on."""
        found = np.zeros(self.size + self.structure.trash, dtype=bool)
        for group, placement in zip(self.layout.groups, self.structure.placements, strict=True):
            for use, tangent in {(use, tangent) for _, use, tangent in group.jacobian}:
                found[placement.gradient_at[:, use] + tangent] = True
        return found[: self.size]

    # --- checks ------------------------------------------------------------------------------

    def check_start(self) -> None:
        """Check that a solve can start.

        Raises
        ------
        SolveError
            E1006 nothing can move; E1007 a parameter starts outside its bounds; E0730 bounds that
            leave no value; E1018 a look-up is outside of its table.
        """
        system = self.structure.system
        if len(system.held) == system.size:
            raise SolveError(
                Diagnostic(
                    "E1006",
                    "there is nothing to solve for: every parameter is fixed or frozen"
                    if any(len(b.first) for b in system.blocks)
                    else "there is nothing to solve for: the data holds no parameters",
                    origin=self.layout.name,
                    help=("free a parameter, or evaluate the cost without solving",),
                )
            )
        check_start(system, self.states)
        for number, group in enumerate(self.layout.groups):
            if group.look_ups:
                # Imported here for start-up time: only models with look-ups need it.
                from arael.runtime.evaluation.look_up_tables import check_inside

                check_inside(self, number)

    def number_instances(self) -> None:
        """Write each instance's number into its `constraint_index` column, -1 where inactive."""
        first = 0
        for group, active in zip(self.layout.groups, self.structure.active, strict=True):
            if group.index_column:
                column = self.store.tables[group.table].column(group.index_column)
                if group.case_of < 0:
                    column[...] = -1
                column[active] = first + np.arange(len(active))
            first += len(active)
