"""Which blocks small groups couple, and where their contributions go: many groups at a time.

A hundred residuals given at run time have a row or two each; NumPy's cost per call would be paid
for each of them.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from arael.runtime.access import Ints
from arael.runtime.layout import Group, pair_count
from arael.runtime.linear.pattern import BlockPattern
from arael.runtime.placement import Placement, uncoupled_pairs
from arael.runtime.system import System

SMALL = 1000
"""Instances up to which a group is small; of larger ones the copies made here would count."""


class Batch:
    """Some groups together; arrays are laid out one group, then one use or pair after the other.

    Parameters
    ----------
    groups : the groups
    slot_rows : per group, the rows of each slot
    system : what is solved for
    """

    def __init__(
        self, groups: Sequence[Group], slot_rows: Sequence[list[Ints]], system: System
    ) -> None:
        self._system = system
        self._shapes = [
            (len(ways[0]) if ways else 0, len(group.uses))
            for group, ways in zip(groups, slot_rows, strict=True)
        ]
        sizes = [len(blocks.first) for blocks in system.blocks]
        shift = np.concatenate(([0], np.cumsum(sizes))).astype(np.int64)
        none = np.zeros(0, dtype=np.int64)
        ways = [
            (rows[use.slot], shift[use.entity])
            for group, rows in zip(groups, slot_rows, strict=True)
            for use in group.uses
        ]
        self._rows = np.concatenate([none, *(rows for rows, _ in ways)])
        at = self._rows + np.repeat(
            np.array([s for _, s in ways], dtype=np.int64), [len(rows) for rows, _ in ways]
        )
        first = np.concatenate([none, *(blocks.first for blocks in system.blocks)])[at]
        self._first = np.where(first >= 0, first, system.size)
        block = np.concatenate([none, *(blocks.block for blocks in system.blocks)])[at]
        self._pair(groups, block)

    def _pair(self, groups: Sequence[Group], block: Ints) -> None:
        left, right, coupled, crossed, lengths = [block[:0]], [block[:0]], [], [], []
        start = 0
        for group, (n, uses) in zip(groups, self._shapes, strict=True):
            uncoupled = uncoupled_pairs(group)
            of = [block[start + u * n : start + (u + 1) * n] for u in range(uses)]
            start += uses * n
            for a in range(uses):
                for b in range(a + 1):
                    left.append(of[a])
                    right.append(of[b])
                    coupled.append((a, b) not in uncoupled)
                    crossed.append(a != b)
                    lengths.append(n)
        self._left, self._right = np.concatenate(left), np.concatenate(right)
        self._both = (self._left >= 0) & (self._right >= 0)
        self._both &= np.repeat(np.array(coupled, dtype=bool), lengths)
        self._crossed = np.repeat(np.array(crossed, dtype=bool), lengths)

    def pairs(self) -> tuple[Ints, Ints]:
        """Blocks that are coupled with each other."""
        chosen = self._both & self._crossed
        return self._left[chosen], self._right[chosen]

    def placements(self, pattern: BlockPattern) -> list[Placement]:
        """Where the contributions of each group go."""
        i, j, both = self._left, self._right, self._both
        block_at = np.full(len(i), pattern.value_count, dtype=np.int64)
        block_at[both] = pattern.find(i[both], j[both])
        turn = np.where(i == j, 2, np.where(i < j, 1, 0))
        turn = np.where(both & self._crossed, turn, 0).astype(np.uint8)
        rows, first = self._rows.astype(np.int32), self._first.astype(np.int32)
        found = []
        use = pair = 0
        for n, uses in self._shapes:
            pairs = pair_count(uses)
            mine, ours = slice(use, use + uses * n), slice(pair, pair + pairs * n)
            found.append(
                Placement(
                    rows[mine].reshape(uses, n).T,
                    first[mine].reshape(uses, n).T,
                    block_at[ours].reshape(pairs, n).T,
                    turn[ours].reshape(pairs, n).T,
                )
            )
            use, pair = mine.stop, ours.stop
        return found
