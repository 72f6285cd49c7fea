"""Private copies of targets that several shares add to, behind the arrays of J'r and J'J."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.layout import pair_of

Ints = NDArray[np.int64]

# Scalars of a cache line, so that two shares never write to the same.
_LINE = 16


@dataclass(frozen=True)
class Copies:
    """Targets of all shares.

    Attributes
    ----------
    placed : per group rows, gradient_at, block_at and turn of its instances, in their order
    gradient_extent, value_extent : scalars of the arrays, with trash and copies
    gradient_sums, value_sums : (m, 3) int64
        Target, copy and count of what is added at the end, by target, then by share.
    nowhere : (shares,) int64, where in the values goes what is not solved for
    """

    placed: Sequence[list[NDArray[Any]]]
    gradient_extent: int
    value_extent: int
    gradient_sums: Ints
    value_sums: Ints
    nowhere: Ints


def copies_of(
    placed: Sequence[list[NDArray[Any]]],
    widths: Sequence[int],
    bounds: Sequence[Ints],
    free: Sequence[bool],
    pattern: BlockPattern,
    trash: int,
    limit: float,
) -> Copies | None:
    """Targets of a split; `placed` is changed unless the copies take more than `limit` values.

    Parameters
    ----------
    placed : per group, arrays of its placement, its instances in their order
    widths : per group, its lanes
    bounds : per group (count + 1,) blocks of lanes at which its shares begin and end
    free : per group, whether it is split; what is left whole has no copies
    """
    return _Split(placed, widths, bounds, free, pattern, trash).copies(limit)


class _Split:
    """One split, with the blocks that each share adds to."""

    def __init__(
        self,
        placed: Sequence[list[NDArray[Any]]],
        widths: Sequence[int],
        bounds: Sequence[Ints],
        free: Sequence[bool],
        pattern: BlockPattern,
        trash: int,
    ) -> None:
        self.placed, self.widths, self.bounds, self.free = placed, widths, bounds, free
        self.pattern, self.trash = pattern, trash
        self.count = count = len(bounds[0]) - 1
        self.sizes = np.append(pattern.sizes, trash)
        nb = pattern.block_count
        block_of = np.full(pattern.size + 1, nb, dtype=np.int64)
        block_of[: pattern.size] = np.repeat(np.arange(nb), pattern.sizes)
        # Block of each use of each instance; the last one stands for what is not solved for.
        self.blocks = [block_of[arrays[1]] for arrays in self.placed]
        self.touched = np.zeros((count, nb + 1), dtype=bool)
        for share, _, a, b, blocks in self._parts():
            for u in range(blocks.shape[1]):
                self.touched[share, blocks[a:b, u]] = True

    def _parts(self) -> list[tuple[int, int, int, int, Ints]]:
        """Share, group, first instance and end, and blocks of each part that is not empty."""
        found = []
        for g, (bounds, width, may) in enumerate(
            zip(self.bounds, self.widths, self.free, strict=True)
        ):
            n = len(self.blocks[g])
            for share in range(self.count):
                a = min(n, int(bounds[share]) * width)
                b = min(n, int(bounds[share + 1]) * width)
                if may and a < b:
                    found.append((share, g, a, b, self.blocks[g]))
        return found

    def copies(self, limit: float) -> Copies | None:
        """The resulting targets; None if the copies take more than `limit` values."""
        pattern, nb = self.pattern, self.pattern.block_count
        shared = self.touched.sum(axis=0) > 1
        shared[nb] = False
        mine = self.touched & shared
        mine[np.argmax(mine, axis=0), np.arange(nb + 1)] = False
        if (mine * self.sizes**2).sum() > limit:
            return None
        pairs = self._pairs(shared)
        if pairs[:, 2].sum() > limit:
            return None
        every = mine.copy()
        every[1:, nb] = True  # a trash of its own for each share
        gradient_at, gradient_extent = _places(every, self.sizes, pattern.size + self.trash)
        diagonal_at, extent = _places(every, self.sizes**2, pattern.value_count + self.trash**2)
        places = extent + np.cumsum(pairs[:, 2]) - pairs[:, 2]
        value_extent = extent + int(pairs[:, 2].sum())
        first = np.append(pattern.offsets[:-1], pattern.size)
        diagonal = pattern.value_start[pattern.column_start[:-1]]
        diagonal = np.append(diagonal, pattern.value_count)
        share, block = np.nonzero(mine)
        gradient_sums = np.stack((first[block], gradient_at[share, block], self.sizes[block]), 1)
        value_sums = np.concatenate(
            (
                np.stack((diagonal[block], diagonal_at[share, block], self.sizes[block] ** 2), 1),
                np.stack((pairs[:, 0], places, pairs[:, 2]), 1),
            )
        )
        for k, g, a, b, blocks in self._parts():
            if k:
                _, at, block_at, _ = self.placed[g]
                at[a:b] += np.where(every[k], gradient_at[k] - first, 0)[blocks[a:b]].astype(
                    np.int32
                )
                move = np.where(every[k], diagonal_at[k] - diagonal, 0)
                chosen = pairs[:, 1] == k
                table = pairs[chosen, 0], places[chosen]
                _redirect(block_at[a:b], blocks[a:b], move, pattern, table)
        return Copies(
            self.placed,
            gradient_extent,
            value_extent,
            _by_target(gradient_sums),
            _by_target(value_sums),
            np.append(diagonal_at[1:, nb], pattern.value_count),
        )

    def _pairs(self, shared: NDArray[np.bool_]) -> Ints:
        """(m, 3) offset, share and area of each block off the diagonal that needs a place."""
        values = self.pattern.value_count
        keys, areas = [np.zeros(0, dtype=np.int64)], [np.zeros(0, dtype=np.int64)]
        for share, g, a, b, blocks in self._parts():
            at = self.placed[g][2][a:b]
            for i in range(blocks.shape[1]):
                for j in range(i):
                    one, other = blocks[a:b, i], blocks[a:b, j]
                    offset = at[:, pair_of(i, j)]
                    both = shared[one] & shared[other] & (one != other) & (offset != values)
                    keys.append(offset[both] * self.count + share)
                    areas.append((self.sizes[one] * self.sizes[other])[both])
        key, area = np.concatenate(keys), np.concatenate(areas)
        order = np.argsort(key, kind="stable")
        key, area = key[order], area[order]
        once = np.diff(key, prepend=-1) > 0
        offsets = key[once] // self.count
        # The first share of each block has the block itself.
        later = np.diff(offsets, prepend=-1) == 0
        found: Ints = np.stack((offsets, key[once] % self.count, area[once]), axis=1)[later]
        return found


def _places(wanted: NDArray[np.bool_], sizes: Ints, begin: int) -> tuple[Ints, int]:
    """Places behind `begin` for all wanted, share by share on lines of their own; and the end."""
    at = np.zeros(wanted.shape, dtype=np.int64)
    end = begin
    for share in range(len(wanted)):
        end = -(-end // _LINE) * _LINE
        extent = np.where(wanted[share], sizes, 0)
        at[share] = end + np.cumsum(extent) - extent
        end += int(extent.sum())
    return at, -(-end // _LINE) * _LINE


def _redirect(
    block_at: Ints, blocks: Ints, move: Ints, pattern: BlockPattern, table: tuple[Ints, Ints]
) -> None:
    """Point the contributions of some instances to the places of their share, in place."""
    trash, offsets, places = pattern.value_count, *table
    for i in range(blocks.shape[1]):
        for j in range(i + 1):
            at = block_at[:, pair_of(i, j)]
            nothing = at == trash
            one = np.where(nothing, len(move) - 1, blocks[:, i])
            diagonal = nothing | (blocks[:, i] == blocks[:, j])
            shift = np.where(diagonal, move[one], 0)
            if len(offsets):
                found = np.minimum(np.searchsorted(offsets, at), len(offsets) - 1)
                there = ~diagonal & (offsets[found] == at)
                shift += np.where(there, places[found] - at, 0)
            at += shift


def _by_target(sums: Ints) -> Ints:
    # A block's places ascend with the shares, so a stable sort keeps them in order.
    order = np.lexsort((sums[:, 1], sums[:, 0]))
    return np.ascontiguousarray(sums[order])
