"""What of a problem lasts until its structure changes: who acts, on what, and where it goes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from arael.diagnostics.records import Diagnostic
from arael.runtime.access import Ints, StoreLike, Walker, gather, outputs
from arael.runtime.failures import SolveError
from arael.runtime.layout import Group
from arael.runtime.linear.pattern import BlockPattern
from arael.runtime.placement import Placement, pattern_and_placements
from arael.runtime.system import System, build_system, free_scalars, row_name
from arael.runtime.tape import Natives


@dataclass(frozen=True)
class Structure:
    """Active instances, system, block pattern and placements of one state of the store."""

    version: Any  # of the store
    flags: tuple[int | None, ...]  # versions of the flags of each entity's table
    frozen: frozenset[str]
    active: tuple[Ints, ...]
    slot_rows: tuple[list[Ints], ...]
    system: System
    pattern: BlockPattern
    placements: tuple[Placement, ...]
    trash: int  # scalars behind the gradient; its square behind the values
    shares: dict[Any, Any] = field(default_factory=dict, compare=False, repr=False)


def structure_of(
    store: StoreLike,
    frozen: frozenset[str] = frozenset(),
    known: Structure | None = None,
    natives: Natives | None = None,
) -> Structure:
    """The structure of a store; `known` itself if nothing of it has changed."""
    layout = store.layout
    if known is not None and _still_holds(store, frozen, known, natives):
        return known
    active = [active_rows(store, group, natives) for group in layout.groups]
    free = [free_scalars(store, entity, frozen) for entity in layout.entities]
    slot_rows = [_slot_rows(store, g, a) for g, a in zip(layout.groups, active, strict=True)]
    system = build_system(store, free)
    pattern, placements = pattern_and_placements(
        layout.groups, layout.coupled, slot_rows, active, system
    )
    trash = max((entity.tangent for entity in layout.entities), default=1)
    return Structure(
        store.structure_version,
        tuple(store.tables[entity.table].flags_version for entity in layout.entities),
        frozen,
        tuple(active),
        tuple(slot_rows),
        system,
        pattern,
        tuple(placements),
        trash,
    )


def _still_holds(
    store: StoreLike, frozen: frozenset[str], known: Structure, natives: Natives | None
) -> bool:
    """Whether rows, refs, guards and what moves are as they were when `known` was made."""
    if known.system.store is not store or known.version != store.structure_version:
        return False
    for group, active in zip(store.layout.groups, known.active, strict=True):
        if group.guard is not None and not np.array_equal(
            active_rows(store, group, natives), active
        ):
            return False
    for entity, blocks, version in zip(
        store.layout.entities, known.system.blocks, known.flags, strict=True
    ):
        now = store.tables[entity.table].flags_version
        if now is not None and now == version and known.frozen == frozen:
            continue
        if not np.array_equal(free_scalars(store, entity, frozen), blocks.free):
            return False
    return True


def active_rows(store: StoreLike, group: Group, natives: Natives | None = None) -> Ints:
    """Rows of the group's table whose guard holds, ascending."""
    rows = np.arange(store.tables[group.table].size, dtype=np.int64)
    if group.guard is None or len(rows) == 0:
        return rows
    walker = Walker(store, group.table, rows)
    ways = [walker.rows(slot) for slot in group.slots]
    inputs = [gather(store, group.slots, ways, raw) for raw in group.guard_raw]
    holds = outputs(group.guard, inputs, len(rows), natives)[0]
    return np.flatnonzero((holds != 0) & ~np.isnan(holds)).astype(np.int64)


def _slot_rows(store: StoreLike, group: Group, active: Ints) -> list[Ints]:
    walker = Walker(store, group.table, active)
    found = []
    needed = {raw.slot for raw in group.raw} | {use.slot for use in group.uses}
    for number, slot in enumerate(group.slots):
        rows = walker.rows(slot)
        # What only a guard looks at may be null where the guard holds.
        if number in needed and len(rows) and rows.min() < 0:
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
    return found
