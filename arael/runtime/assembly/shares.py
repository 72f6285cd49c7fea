"""Splits the instances of a problem into shares that threads accumulate concurrently.

Every share adds to gradient and blocks independently. Targets of a single share are at their usual
offsets. For targets of several shares, the first share uses the usual offset, the others have a
private copy each behind the arrays, and the copies are summed in the order of the shares. The split
depends on the problem and the machine, never on the number of threads, so sums have the same bits
on any number.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.assembly.firsts import plan_firsts
from arael.runtime.assembly.ordering import order_of, runs
from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.assembly.structure import Structure
from arael.runtime.evaluation.instances import in_lanes
from arael.runtime.layout import Group, Layout, pair_of
from arael.runtime.parallel.pool import cores

Ints = NDArray[np.int64]

#: Shares of a problem that is cut for few threads. Divides evenly by 2, 4 and 8, and well by 3.
SHARES = 8


def shares_for(processors: int) -> int:
    """Most shares on a machine of so many processors: a power of two from `SHARES` to 64.

    More than eight make one and two threads up to 8 % slower (docs/internals/threads.md), so only
    machines that can use them get them. The number follows from the machine and never from the
    threads of a solve.
    """
    most = SHARES
    while most < min(processors, 64):
        most *= 2
    return most


#: Most shares of a problem on this machine.
MOST_SHARES = shares_for(cores())

#: Predicted nanoseconds from which a share of its own pays.
GRAIN = 200_000.0

#: The same of each share beyond `SHARES`. Eight shares leave nothing to do for more threads, and
#: with more of them one thread has more to add up, so only long linearisations get more.
WIDE_GRAIN = 1_000_000.0

# A linearisation of fewer grains stays whole.
_SHORT = 4

# Places of their own may take this fraction of the values, and this one beyond `SHARES`.
_ROOM = 0.25
_WIDE_ROOM = 0.05

_NONE: Ints = np.zeros((0, 3), dtype=np.int64)

# Values that fit into the first-level cache: finding first writers takes longer than zeroing them
# in thousands of linearisations.
_CACHED = 4096

# Scalars of a cache line, so that two shares never write to the same.
_LINE = 16


@dataclass(frozen=True)
class Shares:
    """How the instances of all groups are split.

    Attributes
    ----------
    count : shares; 1 if the problem is not split
    bounds : per group (count + 1,) int64, blocks of lanes at which its shares begin and end
    orders : per group, its instances in the order of the lanes, or None: as they come
    placed : per group rows, gradient_at, block_at, turn, run and first in lane order
    gradient_room, value_room : scalars of the arrays, with trash and the places of the shares
    gradient_sums, value_sums : (m, 3) int64
        Target, source and count of what is added at the end, by target, then by share.
    nowhere : where in the values goes what is not solved for, by share
    cleared : (m, 2) int64, begin and end of the values that are emptied before
    cleared_ends : (count + 1,) int64, rows of `cleared` that each share empties
    """

    count: int
    bounds: tuple[Ints, ...]
    orders: tuple[Ints | None, ...]
    placed: tuple[list[NDArray[Any]], ...]
    gradient_room: int
    value_room: int
    gradient_sums: Ints
    value_sums: Ints
    nowhere: Ints
    cleared: Ints
    cleared_ends: Ints


def plan_shares(
    structure: Structure,
    layout: Layout,
    widths: Sequence[int],
    free: Sequence[bool],
    stores: Sequence[bool],
) -> Shares:
    """Split the instances of a structure; the same split for the same structure, always.

    Parameters
    ----------
    widths : per group, its lanes
    free : per group, whether threads may run it; what they may not is left whole
    stores : per group, whether it stores where it is the first to write, as `Lanes.first` says
    """
    groups = layout.groups
    work = [
        _nanoseconds(group) * len(p.rows) if may else 0.0
        for group, p, may in zip(groups, structure.placements, free, strict=True)
    ]
    orders = _orders(structure, groups)
    count = _count(sum(work))
    while count > 1:
        bounds = [
            _bounds(len(p.rows), width, count if one >= GRAIN else 1, count)
            for p, width, one in zip(structure.placements, widths, work, strict=True)
        ]
        found = _Split(structure, orders, widths, bounds, free, count).shares()
        if found is not None:
            return _with_firsts(found, structure, layout, free, stores)
        count //= 2
    bounds = [
        _bounds(len(p.rows), width, 1, 1)
        for p, width in zip(structure.placements, widths, strict=True)
    ]
    whole = Shares(
        1,
        tuple(bounds),
        orders,
        tuple(
            _lanes_of(p.arrays(order), width)
            for p, order, width in zip(structure.placements, orders, widths, strict=True)
        ),
        structure.system.size + structure.trash,
        structure.pattern.value_count + structure.trash**2,
        _NONE,
        _NONE,
        np.array([structure.pattern.value_count]),
        _NONE,
        _NONE,
    )
    # What threads may not run takes its turn with the others if nothing is split.
    return _with_firsts(whole, structure, layout, [True] * len(groups), stores)


def _with_firsts(
    shares: Shares,
    structure: Structure,
    layout: Layout,
    free: Sequence[bool],
    stores: Sequence[bool],
) -> Shares:
    """The same with first writers, ranges to zero, and blocks of lanes with a common lead."""
    groups = layout.groups
    counts = [len(p.rows) for p in structure.placements]
    if shares.count == 1 and shares.value_room <= _CACHED:
        return _all_added(shares, groups, counts)
    # Places belong to one share each, where groups take turns; what is left whole comes last.
    order = sorted(range(len(groups)), key=lambda g: not free[g])
    firsts = plan_firsts(
        groups,
        layout.entities,
        [arrays[2:4] for arrays in shares.placed],
        counts,
        order,
        stores,
        shares.nowhere,
        shares.value_room,
        shares.count,
    )
    placed = tuple(
        [*arrays, runs(arrays[0][:, list(group.lead)], count), first]
        for arrays, group, count, first in zip(
            shares.placed, groups, counts, firsts.first, strict=True
        )
    )
    return replace(shares, placed=placed, cleared=firsts.cleared, cleared_ends=firsts.ends)


def _all_added(shares: Shares, groups: Sequence[Group], counts: Sequence[int]) -> Shares:
    """The same with all values zeroed and every contribution added, without first writers."""
    placed = tuple(
        [
            *arrays,
            runs(arrays[0][:, list(group.lead)], count),
            np.zeros(arrays[2].shape[:2], dtype=np.uint8),
        ]
        for arrays, group, count in zip(shares.placed, groups, counts, strict=True)
    )
    cleared = np.array([[0, shares.value_room]], dtype=np.int64)
    return replace(shares, placed=placed, cleared=cleared, cleared_ends=np.array([0, 1]))


def _count(nanoseconds: float) -> int:
    """Number of shares for a linearisation of so many nanoseconds, as far as there is space."""
    # Waking a helper may take as long as a short linearisation.
    if nanoseconds < _SHORT * GRAIN:
        return 1
    most = MOST_SHARES
    while most > SHARES and nanoseconds < most * max(WIDE_GRAIN, GRAIN):
        most //= 2
    return int(min(most, nanoseconds // GRAIN))


def _nanoseconds(group: Group) -> float:
    """Predicted time to linearise one instance."""
    return 10.0 + 0.1 * group.operations_after


def _bounds(instances: int, width: int, parts: int, count: int) -> Ints:
    blocks = -(-instances // width)
    if count == 1:
        return np.array([0, blocks], dtype=np.int64)
    ends = np.arange(count + 1, dtype=np.int64) * blocks // count
    return ends if parts > 1 else np.where(np.arange(count + 1) > 0, blocks, 0).astype(np.int64)


def _orders(structure: Structure, groups: Sequence[Group]) -> tuple[Ints | None, ...]:
    return tuple(
        order_of(group, p.rows, p.block_at, structure.pattern.value_count)
        for group, p in zip(groups, structure.placements, strict=True)
    )


def _lanes_of(arrays: list[NDArray[Any]], width: int) -> list[NDArray[Any]]:
    return [in_lanes(array, width) for array in arrays]


class _Split:
    """One split of a structure, with the copies that it needs."""

    def __init__(
        self,
        structure: Structure,
        orders: tuple[Ints | None, ...],
        widths: Sequence[int],
        bounds: list[Ints],
        free: Sequence[bool],
        count: int,
    ) -> None:
        self.structure, self.widths, self.bounds, self.free = structure, widths, bounds, free
        self.count = count
        pattern = structure.pattern
        self.sizes = np.append(pattern.sizes, structure.trash)
        nb = pattern.block_count
        block_of = np.full(structure.system.size + 1, nb, dtype=np.int64)
        block_of[: structure.system.size] = np.repeat(np.arange(nb), pattern.sizes)
        # Block of each use of each instance; the last one stands for what is not solved for.
        self.orders = orders
        self.placed = [
            p.arrays(order) for p, order in zip(structure.placements, self.orders, strict=True)
        ]
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

    def shares(self) -> Shares | None:
        """The resulting shares; None if the copies take too much memory."""
        structure, nb = self.structure, self.structure.pattern.block_count
        shared = self.touched.sum(axis=0) > 1
        shared[nb] = False
        mine = self.touched & shared
        mine[np.argmax(mine, axis=0), np.arange(nb + 1)] = False
        fraction = _ROOM if self.count <= SHARES else _WIDE_ROOM
        limit = fraction * structure.pattern.value_count
        if (mine * self.sizes**2).sum() > limit:
            return None
        pairs = self._pairs(shared)
        if pairs[:, 2].sum() > limit:
            return None
        every = mine.copy()
        every[1:, nb] = True  # a trash of its own for each share
        gradient_at, gradient_room = _places(
            every, self.sizes, structure.system.size + structure.trash
        )
        diagonal_at, room = _places(
            every, self.sizes**2, structure.pattern.value_count + structure.trash**2
        )
        places = room + np.cumsum(pairs[:, 2]) - pairs[:, 2]
        value_room = room + int(pairs[:, 2].sum())
        first = np.append(structure.pattern.offsets[:-1], structure.system.size)
        diagonal = structure.pattern.value_start[structure.pattern.column_start[:-1]]
        diagonal = np.append(diagonal, structure.pattern.value_count)
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
                _redirect(block_at[a:b], blocks[a:b], move, structure.pattern, table)
        return Shares(
            self.count,
            tuple(self.bounds),
            self.orders,
            tuple(
                _lanes_of(arrays, width)
                for arrays, width in zip(self.placed, self.widths, strict=True)
            ),
            gradient_room,
            value_room,
            _by_target(gradient_sums),
            _by_target(value_sums),
            np.append(diagonal_at[1:, nb], structure.pattern.value_count),
            _NONE,
            _NONE,
        )

    def _pairs(self, shared: NDArray[np.bool_]) -> Ints:
        """(m, 3) offset, share and area of each block off the diagonal that needs a place."""
        values = self.structure.pattern.value_count
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
        room = np.where(wanted[share], sizes, 0)
        at[share] = end + np.cumsum(room) - room
        end += int(room.sum())
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
