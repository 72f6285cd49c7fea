"""Where the contributions of a group's instances go in gradient and blocks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.access import Ints
from arael.runtime.layout import Group, pair_count, pair_of
from arael.runtime.linear.pattern import BlockPattern
from arael.runtime.system import System


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
    """

    rows: NDArray[np.int32]
    gradient_at: NDArray[np.int32]
    block_at: Ints
    turn: NDArray[np.uint8]

    def arrays(self, order: Ints | None) -> list[NDArray[Any]]:
        """Copies of rows, gradient_at, block_at and turn, of instances as `order` says."""
        arrays = self.rows, self.gradient_at, self.block_at, self.turn
        return [a.copy() if order is None else a[order] for a in arrays]


def uncoupled_pairs(group: Group) -> set[tuple[int, int]]:
    """Pairs of uses ``(a, b)``, a > b, that no residual reads together: their block stays zero."""
    residuals: list[set[int]] = [set() for _ in group.uses]
    for residual, use, _ in group.jacobian:
        residuals[use].add(residual)
    uses = range(len(group.uses))
    return {(a, b) for a in uses for b in range(a) if not residuals[a] & residuals[b]}


def placement_of(
    group: Group, ways: list[Ints], n: int, system: System, pattern: BlockPattern
) -> Placement:
    """Where the contributions of `n` instances go, whose rows are `ways` by slot."""
    uses = group.uses
    pairs = pair_count(len(uses))
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
            pair = pair_of(a, b)
            both = (blocks[a] >= 0) & (blocks[b] >= 0)
            if (a, b) in uncoupled or not both.any():
                continue
            i, j = blocks[a][both], blocks[b][both]
            block_at[both, pair] = pattern.find(i, j)
            if a != b:
                turn[both, pair] = np.where(i == j, 2, np.where(i < j, 1, 0))
    return Placement(rows, gradient_at, block_at, turn)
