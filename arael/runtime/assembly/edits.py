"""The scatter plan after an edit of few instances: what the others add to stays as it is.

A row appended or removed, a ref that leads elsewhere, a guard over data that switches: as long as
the same scalars are solved for and the same blocks are coupled, only the instances in between the
unchanged ones are placed anew. The result is the plan that `scatter_plan` computes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.assembly.compiled import (
    add_counts,
    common_ends,
    leads_behind,
    placed_pairs,
    used_rows,
)
from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.assembly.placement import Placement
from arael.runtime.assembly.scatter_plan import ScatterPlan
from arael.runtime.assembly.shares import edited_shares
from arael.runtime.compiled import read_only
from arael.runtime.layout import Group, Layout
from arael.runtime.store.access import Ints
from arael.runtime.system import System

# Up to this part of all instances may have changed; if more have, all are placed anew.
_FEW = 0.25


@dataclass(eq=False)  # not frozen: its constructor would take three times as long
class _Ends:
    """Instances of a group that use the rows that they used before, and those in between.

    Attributes
    ----------
    now, before : per use, rows of the instances
    count, count_before : instances
    first, last : unchanged instances at the beginning and at the end
    """

    now: list[Ints]
    before: list[Ints]
    count: int
    count_before: int
    first: int
    last: int

    @property
    def changed(self) -> int:
        """Instances that are new or gone."""
        return max(self.count, self.count_before) - self.first - self.last

    @property
    def new(self) -> slice:
        """Instances that are not those of before."""
        return slice(self.first, self.count - self.last)

    @property
    def old(self) -> slice:
        """Instances of before that are no more."""
        return slice(self.first, self.count_before - self.last)


def edited_plan(
    layout: Layout,
    known: ScatterPlan,
    rows_before: Sequence[list[Ints]],
    slot_rows: Sequence[list[Ints]],
    active: Sequence[Ints],
    system: System,
) -> ScatterPlan | None:
    """The plan of the active instances, from an earlier one for the same system.

    Parameters
    ----------
    known : the earlier plan
    rows_before : per group, the row of each slot of the active instances of `known`
    slot_rows, active, system : as for `scatter_plan`

    Returns
    -------
    None if many instances have changed, or if other blocks are coupled now.
    """
    ends = [
        _ends_of(group, now, before, len(rows), len(rows_then))
        for group, now, before, rows, rows_then in zip(
            layout.groups, slot_rows, rows_before, active, known.active, strict=True
        )
    ]
    if sum(one.changed for one in ends) > _FEW * sum(one.count for one in ends):
        return None
    pattern, behind = known.pattern, known.behind
    placements: list[Placement] = []
    for one, was, group, coupled in zip(
        ends, known.placements, layout.groups, layout.coupled, strict=True
    ):
        placed = (was, 0)
        if one.changed:
            found = _placed(one, was, group, coupled, pattern, system)
            if found is None:
                return None
            placed = found
        placements.append(placed[0])
        behind += placed[1]
    counts = known.take_counts()
    nowhere, gone = pattern.value_count, []
    for one, was, now in zip(ends, known.placements, placements, strict=True):
        if one.changed:
            new, old = one.new, one.old
            add_counts(counts, now.block_at[new], now.turn[new], nowhere, 1)
            gone.append((was.block_at[old], was.turn[old]))
    left = [add_counts(counts, *places, nowhere, -1) for places in gone]
    if not all(left) or (behind > 0) != pattern.by_rows:
        return None
    read_only(*active)
    plan = ScatterPlan(
        known.groups,
        known.entities,
        tuple(active),
        pattern,
        tuple(placements),
        known.trash,
        behind,
        _diagonal_at=known._diagonal_at,
        _counts=counts,
    )
    for execution, shares in known._shares.items():
        plan._shares[execution] = edited_shares(
            plan.groups,
            plan.entities,
            pattern,
            placements,
            known.trash,
            execution,
            shares,
            [one.first if one.changed else None for one in ends],
        )
    return plan


def _ends_of(
    group: Group, now: list[Ints], before: list[Ints], count: int, count_before: int
) -> _Ends:
    """Which instances of a group are unchanged."""
    rows = [np.ascontiguousarray(now[use.slot]) for use in group.uses]
    were = [np.ascontiguousarray(before[use.slot]) for use in group.uses]
    if now is before and count == count_before:
        ends = count, 0
    else:
        ends = common_ends(rows, were, count, count_before)
    return _Ends(rows, were, count, count_before, *ends)


def _placed(
    one: _Ends,
    was: Placement,
    group: Group,
    coupled: NDArray[np.uint8],
    pattern: BlockPattern,
    system: System,
) -> tuple[Placement, int] | None:
    """Where the instances of a group add now, and by how much `behind` grows.

    None if the pattern lacks a block that they couple.
    """
    blocks = [system.blocks[use.entity] for use in group.uses]
    new, old = one.new, one.old
    rows, gradient_at, block = used_rows(
        [way[new] for way in one.now], blocks, new.stop - new.start, system.size
    )
    pairs = placed_pairs(block, coupled, pattern, pattern.value_count, False)
    if pairs is None:
        return None
    more = 0
    if group.lead:
        ways = [way[old] for way in one.before]
        then = used_rows(ways, blocks, old.stop - old.start, system.size)[2]
        more = leads_behind(block, group.lead[0]) - leads_behind(then, group.lead[0])
    end = one.count_before - one.last
    arrays: list[NDArray[Any]] = [rows, gradient_at, *pairs]
    found = [
        np.concatenate((array[: one.first], fresh, array[end:]))
        for array, fresh in zip(was.in_order(), arrays, strict=True)
    ]
    read_only(*found)
    return Placement(*found), more
