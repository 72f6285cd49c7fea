"""Scatter plan: offsets in gradient and blocks at which a group's instances are added."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.assembly.compiled import has_blocks, placed_pairs, uses_and_keys
from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.layout import Group
from arael.runtime.store.access import Ints
from arael.runtime.system import System


@dataclass(eq=False)  # not frozen: its constructor would take three times as long
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
) -> tuple[BlockPattern, list[Placement], int]:
    """Blocks that are coupled, where each group's contributions go in them, and `behind`.

    Parameters
    ----------
    coupled : per group, which pairs of its uses some residual reads together
    slot_rows : per group, the rows of each slot
    active : per group, its active rows
    known : a pattern of the same system, which is returned if it has these blocks

    Returns
    -------
    pattern, placements
    behind : how often leads stand behind what they are coupled with, less how often before
    """
    used, keys, behind = uses_and_keys(
        groups, coupled, slot_rows, active, system.blocks, len(system.sizes), system.size
    )
    if known is not None:
        keys.sort()
    # Values lie by rows if most leads stand behind what they are coupled with.
    by_rows = behind > 0
    if known is not None and known.by_rows == by_rows and has_blocks(known, keys):
        pattern = known
    else:
        pattern = BlockPattern.from_keys(system.sizes, keys, system.name_of, by_rows=by_rows)
    nowhere = pattern.value_count
    placements = [
        Placement(rows, gradient_at, *placed_pairs(block, chosen, pattern, nowhere))
        for (rows, gradient_at, block), chosen in zip(used, coupled, strict=True)
    ]
    return pattern, placements, behind
