"""What of a problem lasts until its structure changes: who acts, on what, and where it goes."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.diagnostics.records import Diagnostic
from arael.runtime.access import Ints, StoreLike, Walker, gather, outputs
from arael.runtime.failures import SolveError
from arael.runtime.layout import Group
from arael.runtime.linear.pattern import BlockPattern
from arael.runtime.system import System, build_system, free_scalars, row_name
from arael.runtime.tape import Natives


@dataclass(frozen=True)
class Placement:
    """Where the contributions of a group's instances go.

    Pairs of uses are numbered ``a (a + 1) / 2 + b`` for ``a >= b``. What is not solved for goes to
    the trash behind the gradient and the values.

    Attributes
    ----------
    rows : (n, uses) int32, row of each used entity
    gradient_at : (n, uses) int32, first scalar of each use
    block_at : (n, pairs) int64, offset of each pair's block in the values
    turn : (n, pairs) uint8, 0 as computed, 1 transposed, 2 both onto a diagonal block
    lanes : these arrays in lane order by number of lanes, once they have been asked for
    """

    rows: NDArray[np.int32]
    gradient_at: NDArray[np.int32]
    block_at: Ints
    turn: NDArray[np.uint8]
    lanes: dict[int, Any] = field(default_factory=dict, compare=False, repr=False)


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
    pattern = _pattern(layout.groups, slot_rows, system)
    trash = max((entity.tangent for entity in layout.entities), default=1)
    placements = [
        _placement(g, s, len(a), system, pattern)
        for g, s, a in zip(layout.groups, slot_rows, active, strict=True)
    ]
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


def uncoupled_pairs(group: Group) -> set[tuple[int, int]]:
    """Pairs of uses ``(a, b)``, a > b, that no residual reads together: their block stays zero."""
    residuals: list[set[int]] = [set() for _ in group.uses]
    for residual, use, _ in group.jacobian:
        residuals[use].add(residual)
    uses = range(len(group.uses))
    return {(a, b) for a in uses for b in range(a) if not residuals[a] & residuals[b]}


def _slot_rows(store: StoreLike, group: Group, active: Ints) -> list[Ints]:
    walker = Walker(store, group.table, active)
    found = []
    for slot in group.slots:
        rows = walker.rows(slot)
        if len(rows) and rows.min() < 0:
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


def _pattern(
    groups: tuple[Group, ...], slot_rows: list[list[Ints]], system: System
) -> BlockPattern:
    rows, columns = [np.zeros(0, dtype=np.int64)], [np.zeros(0, dtype=np.int64)]
    for group, ways in zip(groups, slot_rows, strict=True):
        blocks = [system.blocks[use.entity].block[ways[use.slot]] for use in group.uses]
        uncoupled = uncoupled_pairs(group)
        for a in range(len(blocks)):
            for b in range(a):
                if (a, b) not in uncoupled:
                    both = (blocks[a] >= 0) & (blocks[b] >= 0)
                    rows.append(blocks[a][both])
                    columns.append(blocks[b][both])
    return BlockPattern.from_pairs(
        system.sizes, np.concatenate(rows), np.concatenate(columns), system.name_of
    )


def _placement(
    group: Group, ways: list[Ints], n: int, system: System, pattern: BlockPattern
) -> Placement:
    uses = group.uses
    pairs = len(uses) * (len(uses) + 1) // 2
    rows = np.zeros((n, len(uses)), dtype=np.int32)
    gradient_at = np.full((n, len(uses)), system.size, dtype=np.int32)
    block_at = np.full((n, pairs), pattern.value_count, dtype=np.int64)
    turn = np.zeros((n, pairs), dtype=np.uint8)
    uncoupled = uncoupled_pairs(group)
    blocks = []
    for u, use in enumerate(uses):
        rows[:, u] = ways[use.slot]
        first = system.blocks[use.entity].first[ways[use.slot]]
        gradient_at[:, u] = np.where(first >= 0, first, system.size)
        blocks.append(system.blocks[use.entity].block[ways[use.slot]])
    for a in range(len(uses)):
        for b in range(a + 1):
            pair = a * (a + 1) // 2 + b
            both = (blocks[a] >= 0) & (blocks[b] >= 0)
            if (a, b) in uncoupled or not both.any():
                continue
            i, j = blocks[a][both], blocks[b][both]
            block_at[both, pair] = pattern.find(i, j)
            if a != b:
                turn[both, pair] = np.where(i == j, 2, np.where(i < j, 1, 0))
    return Placement(rows, gradient_at, block_at, turn)
