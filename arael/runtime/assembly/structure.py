"""Structure of a problem: active instances, block pattern, scatter offsets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import Diagnostic
from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.assembly.placement import Placement
from arael.runtime.assembly.scatter_plan import ScatterPlan, scatter_plan
from arael.runtime.failures import SolveError
from arael.runtime.layout import Group
from arael.runtime.store.access import (
    Bools,
    Ints,
    StoreLike,
    Walker,
    gather,
    lengths_through,
    outputs,
)
from arael.runtime.store.compiled import held_of
from arael.runtime.system import System, build_system, free_scalars, hold, row_name, with_bounds

if TYPE_CHECKING:
    from arael.runtime.machine.compiled import NativeTable

# Blocks in which nothing moves stay in a system up to this many, or up to this part of all.
_FEW_IDLE = 2
_IDLE = 0.1


@dataclass(frozen=True)
class Structure:
    """System and scatter plan of one state of the store."""

    version: Any  # of the store
    tables: dict[str, int]  # versions of the rows of its tables
    flags: tuple[int | None, ...]  # versions of the flags of each entity's table
    bounds: tuple[Any, ...]  # versions of the bounds of its rows
    frozen: frozenset[str]
    slot_rows: tuple[list[Ints], ...]
    system: System
    plan: ScatterPlan
    coupled: tuple[NDArray[np.uint8], ...]  # of each group's uses, as `Layout.coupled`
    idle: int = 0  # blocks of the system in which nothing moves, kept for when it does again
    # Of the components, once they were asked for; see `components.py`.
    partition: list[Any] = field(default_factory=list, compare=False, repr=False)

    @property
    def active(self) -> tuple[Ints, ...]:
        """Per group, its active rows; see `ScatterPlan`."""
        return self.plan.active

    @property
    def pattern(self) -> BlockPattern:
        """The blocks of J'J; see `ScatterPlan`."""
        return self.plan.pattern

    @property
    def placements(self) -> tuple[Placement, ...]:
        """Per group, offsets of its instances; see `ScatterPlan`."""
        return self.plan.placements

    @property
    def trash(self) -> int:
        """Scalars behind the gradient; see `ScatterPlan`."""
        return self.plan.trash


def structure_of(
    store: StoreLike,
    frozen: frozenset[str] = frozenset(),
    known: Structure | None = None,
    natives: NativeTable | None = None,
    keep_idle: bool = False,
) -> Structure:
    """The structure of a store; `known` itself if nothing of it has changed.

    With `keep_idle`, rows that were fixed since `known` was made stay in the system with all their
    scalars held, so that pattern and placements stay too (`_with_other_flags`). Without it the
    structure is that of the store alone.
    """
    layout = store.layout
    if known is not None and (keep_idle or not known.idle):
        same_rows = _same_rows(store, known, natives)
        if same_rows and _same_flags(store, frozen, known):
            return _with_bounds(store, known)
        if same_rows and keep_idle:
            found = _with_other_flags(store, frozen, known)
            if found is not None:
                return found
    versions = _row_versions(store)
    active, slot_rows = [], []
    for number, group in enumerate(layout.groups):
        if known is not None and _same_ways(store, known, number, versions):
            active.append(known.active[number])
            slot_rows.append(known.slot_rows[number])
        else:
            active.append(active_rows(store, group, natives))
            slot_rows.append(rows_of_slots(store, group, active[-1], natives))
    free = [free_scalars(store, entity, frozen) for entity in layout.entities]
    same = _same_system(store, free, known)
    system = same or build_system(store, free)
    plan = None
    if same and known is not None:
        # Imported here for start-up time: a first solve has no plan to edit.
        from arael.runtime.assembly.edits import edited_plan

        plan = edited_plan(layout, known.plan, known.slot_rows, slot_rows, active, system)
    if plan is None:
        before = known.plan if known is not None and same else None
        plan = scatter_plan(layout, slot_rows, active, system, before)
    return Structure(
        store.structure_version,
        versions,
        tuple(store.tables[entity.table].flags_version for entity in layout.entities),
        _bounds_versions(store),
        frozen,
        tuple(slot_rows),
        system,
        plan,
        layout.coupled,
    )


def structure_of_chosen(
    store: StoreLike, chosen: Sequence[Ints], frozen: frozenset[str] = frozenset()
) -> Structure:
    """The structure of some instances of a store: of these, the active ones.

    Parameters
    ----------
    chosen : per group, rows of its table; for a layout without groups none
    """
    layout = store.layout
    active = [
        np.intersect1d(active_rows(store, group), rows, assume_unique=True)
        for group, rows in zip(layout.groups, chosen, strict=True)
    ]
    slot_rows = [rows_of_slots(store, g, a) for g, a in zip(layout.groups, active, strict=True)]
    free = [free_scalars(store, entity, frozen) for entity in layout.entities]
    system = build_system(store, free)
    return Structure(
        store.structure_version,
        _row_versions(store),
        tuple(store.tables[entity.table].flags_version for entity in layout.entities),
        _bounds_versions(store),
        frozen,
        tuple(slot_rows),
        system,
        scatter_plan(layout, slot_rows, active, system),
        layout.coupled,
    )


def _row_versions(store: StoreLike) -> dict[str, int]:
    """Versions of rows and refs of all tables."""
    return {one.path: store.tables[one.path].structure_version for one in store.layout.tables}


def _same_ways(store: StoreLike, known: Structure, number: int, versions: dict[str, int]) -> bool:
    """Whether all tables on the ways of a group have the rows and refs of before."""
    if known.system.store is not store:
        return False
    passed = store.layout.passed[number]
    return passed is not None and all(versions[one] == known.tables[one] for one in passed)


def _same_system(store: StoreLike, free: list[Bools], known: Structure | None) -> System | None:
    """The system of an earlier structure, if the same scalars of the same store move."""
    if known is None or known.idle or known.system.store is not store:
        return None
    before = known.system.blocks
    same = all(np.array_equal(a, b.free) for a, b in zip(free, before, strict=True))
    return _with_bounds(store, known).system if same else None


def _bounds_versions(store: StoreLike) -> tuple[Any, ...]:
    """Versions of the bounds of rows, by entity."""
    return tuple(store.tables[entity.table].bounds_version for entity in store.layout.entities)


def _with_bounds(store: StoreLike, known: Structure) -> Structure:
    """The structure with the bounds of now; `known` itself if they are the same."""
    versions = _bounds_versions(store)
    if versions == known.bounds:
        return known
    return replace(known, bounds=versions, system=with_bounds(known.system), partition=[])


def _same_rows(store: StoreLike, known: Structure, natives: NativeTable | None) -> bool:
    """Whether rows, refs and guards are as they were when `known` was made."""
    if known.system.store is not store or known.version != store.structure_version:
        return False
    for group, active, slot_rows in zip(
        store.layout.groups, known.active, known.slot_rows, strict=True
    ):
        if group.guard is not None and not np.array_equal(
            active_rows(store, group, natives), active
        ):
            return False
        if group.near:
            # Imported here for start-up time: only models with look-ups of parameters need it.
            from arael.runtime.nearness import same_near_rows

            if not same_near_rows(store, group, active, slot_rows, natives):
                return False
    return True


def _same_flags(store: StoreLike, frozen: frozenset[str], known: Structure) -> bool:
    """Whether the same scalars are free as when `known` was made."""
    for entity, blocks, version in zip(
        store.layout.entities, known.system.blocks, known.flags, strict=True
    ):
        now = store.tables[entity.table].flags_version
        if now is not None and now == version and known.frozen == frozen:
            continue
        if not np.array_equal(free_scalars(store, entity, frozen), blocks.free):
            return False
    return True


def _with_other_flags(
    store: StoreLike, frozen: frozenset[str], known: Structure
) -> Structure | None:
    """The structure with other scalars held, on the same blocks; None if it takes new ones.

    What moves must be in the system. Blocks in which nothing moves are held whole: they have an
    identity row, no gradient and no step, so that all else is as if they were not there. Few of
    them are worth keeping, since they are factorised with the others.
    """
    layout, system = store.layout, known.system
    free = [free_scalars(store, entity, frozen) for entity in layout.entities]
    held, idle = held_of(free, [blocks.first for blocks in system.blocks])
    if held is None or idle > max(_FEW_IDLE, _IDLE * len(system.sizes)):
        return None
    return replace(
        known,
        flags=tuple(store.tables[entity.table].flags_version for entity in layout.entities),
        bounds=_bounds_versions(store),
        frozen=frozen,
        system=hold(system, free, held),
        idle=idle,
        partition=[],
    )


def active_rows(store: StoreLike, group: Group, natives: NativeTable | None = None) -> Ints:
    """Rows of the group's table whose guard holds, ascending."""
    rows = np.arange(store.tables[group.table].size, dtype=np.int64)
    if group.lengths and len(rows):
        rows = _of_lengths(store, group, rows)
    if group.guard is None or len(rows) == 0:
        return rows
    walker = Walker(store, group.table, rows)
    ways = [walker.rows(slot) for slot in group.slots]
    inputs = [gather(store, group.slots, ways, raw) for raw in group.guard_raw]
    holds = outputs(group.guard, inputs, len(rows), natives)[0]
    chosen: Ints = rows[(holds != 0) & ~np.isnan(holds)]
    return chosen


def _of_lengths(store: StoreLike, group: Group, rows: Ints) -> Ints:
    """Those of `rows` whose lists have as many rows as the group is for."""
    walker = Walker(store, group.table, rows, True)
    chosen = np.ones(len(rows), dtype=bool)
    for one in group.lengths:
        owners = walker.rows(group.slots[one.slot])
        count = lengths_through(store, one.collection, owners)
        chosen &= (count >= one.low) & (count <= one.high)
    return rows[chosen]


def rows_of_slots(
    store: StoreLike, group: Group, active: Ints, natives: NativeTable | None = None
) -> list[Ints]:
    """Per slot, the row that each active instance reads; E1005 for a null ref on the way."""
    whole = group.guard is None and not group.lengths  # then all rows are active
    walker = Walker(store, group.table, active, whole)
    found = []
    needed = {raw.slot for raw in group.raw} | {use.slot for use in group.uses}
    needed |= {one.slot for one in group.lengths} | {one.slot for one in group.look_ups}
    near = {slot for one in group.look_ups for slot in one.rows}
    for number, slot in enumerate(group.slots):
        if number in near:  # below
            found.append(np.zeros(len(active), dtype=np.int64))
            continue
        rows = walker.rows(slot)
        # What only a guard looks at may be null where the guard holds.
        if slot.steps and number in needed and len(rows) and rows.min() < 0:
            at = int(np.argmin(rows >= 0))
            place = row_name(store, group.table, int(active[at]))
            raise SolveError(
                Diagnostic(
                    "E1005",
                    f"`{place}`: constraint `{group.label}` reads through "
                    f"`{walker.first_null(slot, at)}`, which is null there",
                    origin=group.where,
                    help=("set the ref, or guard the constraint so that it does not act there",),
                )
            )
        found.append(rows)
    if near:
        # Imported here for start-up time: only models with look-ups of parameters need it.
        from arael.runtime.nearness import near_rows

        for number, rows in near_rows(store, group, active, found, natives).items():
            found[number] = rows
    return found
