"""Scatter plan: offsets in gradient and blocks at which a group's instances are added."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.assembly.couplings import (
    add_keys,
    has_blocks,
    leads_behind,
    placed_pairs,
    used_rows,
)
from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.layout import Group, pair_count, uncoupled_pairs
from arael.runtime.store.access import Ints
from arael.runtime.system import System

__all__ = ["Placement", "pattern_and_placements", "uncoupled_pairs"]


@dataclass(frozen=True)
class Placement:
    """Where the contributions of a group's instances go; all arrays are read-only.

    Pairs of uses are numbered ``a (a + 1) / 2 + b`` for ``a >= b``. What is not solved for goes to
    the trash behind the gradient and the values.

    Attributes
    ----------
    rows : (n, uses) int32, row of each used entity
    gradient_at : (n, uses) int32, first scalar of each use
    block_at : (n, pairs) int64, offset of each pair's block in the values
    turn : (n, pairs) uint8, 0 as computed, 1 transposed, 2 both onto a diagonal block
    """

    rows: NDArray[np.int32]
    gradient_at: NDArray[np.int32]
    block_at: Ints
    turn: NDArray[np.uint8]

    def in_order(self) -> tuple[NDArray[Any], ...]:
        """Rows, gradient_at, block_at and turn, of instances as they come."""
        return self.rows, self.gradient_at, self.block_at, self.turn

    def arrays(self, order: Ints | None) -> list[NDArray[Any]]:
        """Copies of rows, gradient_at, block_at and turn, of instances in the order `order`."""
        return [a.copy() if order is None else a[order] for a in self.in_order()]


def pattern_and_placements(
    groups: Sequence[Group],
    coupled: Sequence[NDArray[np.uint8]],
    slot_rows: Sequence[list[Ints]],
    active: Sequence[Ints],
    system: System,
    known: BlockPattern | None = None,
) -> tuple[BlockPattern, list[Placement]]:
    """Blocks that are coupled, and where each group's contributions go in them.

    Parameters
    ----------
    coupled : per group, which pairs of its uses some residual reads together
    slot_rows : per group, the rows of each slot
    active : per group, its active rows
    known : a pattern of the same system, which is returned if it has these blocks
    """
    used = []
    extent = behind = 0
    for group, ways, rows in zip(groups, slot_rows, active, strict=True):
        of = [np.ascontiguousarray(ways[use.slot]) for use in group.uses]
        blocks = [system.blocks[use.entity] for use in group.uses]
        used.append(used_rows(of, blocks, len(rows), system.size))
        extent += len(rows) * (pair_count(len(of)) - len(of))
        if group.lead:
            behind += leads_behind(used[-1][2], group.lead[0])
    keys = np.empty(extent, dtype=np.int64)
    nb, count = len(system.sizes), 0
    for (_, _, block), chosen in zip(used, coupled, strict=True):
        count = add_keys(block, chosen, nb, keys, count)
    keys = keys[:count]
    if known is not None:
        keys.sort()
    # Values lie by rows if most leads stand behind what they are coupled with.
    by_rows = behind > 0
    if known is not None and known.by_rows == by_rows and has_blocks(known, keys):
        pattern = known
    else:
        pattern = BlockPattern.from_keys(system.sizes, keys, system.name_of, by_rows=by_rows)
    nowhere = pattern.value_count
    return pattern, [
        Placement(rows, gradient_at, *placed_pairs(block, chosen, pattern, nowhere))
        for (rows, gradient_at, block), chosen in zip(used, coupled, strict=True)
    ]
