"""Splits the instances of a problem into shares that threads accumulate concurrently.

Every share adds to gradient and blocks independently. Targets of a single share are at their usual
offsets. For targets of several shares, the first share uses the usual offset, the others have a
private copy each behind the arrays, and the copies are summed in the order of the shares. The split
depends on the problem and the machine, never on the number of threads, so sums have the same bits
on any number.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from arael.runtime.assembly.compiled import lane_targets
from arael.runtime.assembly.copies import copies_of
from arael.runtime.assembly.firsts import plan_firsts
from arael.runtime.assembly.ordering import order_of
from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.assembly.placement import Placement
from arael.runtime.compiled import read_only
from arael.runtime.layout import Entity, Group
from arael.runtime.parallel.compiled import cores

Ints = NDArray[np.int64]
Bytes = NDArray[np.uint8]

# `LaneTargets` without `first`.
_Placed = tuple[NDArray[np.int32], NDArray[np.int32], Ints, Bytes, Bytes]

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

# Values that fit into the first-level cache, or nearly: finding first writers takes longer than
# zeroing them in thousands of linearisations.
_CACHED = 8192


# What is added at the end, and the ranges of one share, where there is but one.
_NONE: Ints = np.zeros((0, 3), dtype=np.int64)
_ONE: Ints = np.array([0, 1], dtype=np.int64)
read_only(_NONE, _ONE)


class Execution(NamedTuple):
    """What the evaluation of the groups requires of a plan.

    Attributes
    ----------
    widths : per group, instances that are evaluated together: its lanes
    concurrent : per group, whether threads may evaluate it; otherwise it is left whole
    overwrites : per group, whether it overwrites blocks as in `LaneTargets.first`
    """

    widths: tuple[int, ...]
    concurrent: tuple[bool, ...]
    overwrites: tuple[bool, ...]


class LaneTargets(NamedTuple):
    """Where the lanes of a group add: a `Placement` in lane order, the last block padded.

    Attributes
    ----------
    row : (blocks, uses, lanes) int32
    gradient_at : (blocks, uses, lanes) int32
    block_at : (blocks, pairs, lanes) int64
    turn : (blocks, pairs, lanes) uint8
    run : (blocks,) uint8, whether all lanes have the same rows of the group's lead
    first : (blocks, pairs) uint8, whether all lanes are first writers of the pair's blocks
    """

    row: NDArray[np.int32]
    gradient_at: NDArray[np.int32]
    block_at: Ints
    turn: NDArray[np.uint8]
    run: NDArray[np.uint8]
    first: NDArray[np.uint8]


@dataclass(eq=False)  # not frozen: its constructor would take three times as long
class Shares:
    """How the instances of all groups are split. All arrays are read-only.

    Attributes
    ----------
    count : shares; 1 if the problem is not split
    bounds : per group (count + 1,) int64, blocks of lanes at which its shares begin and end
    orders : per group, its instances in the order of the lanes, or None: as they come
    placed : per group, its targets in lane order
    gradient_extent, value_extent : scalars of the arrays, with trash and the places of the shares
    gradient_sums, value_sums : (m, 3) int64
        Target, source and count of what is added at the end, by target, then by share.
    nowhere : where in the values goes what is not solved for, by share
    cleared : (m, 2) int64, begin and end of the values that are emptied before
    cleared_ends : (count + 1,) int64, rows of `cleared` that each share empties
    """

    count: int
    bounds: tuple[Ints, ...]
    orders: tuple[Ints | None, ...]
    placed: tuple[LaneTargets, ...]
    gradient_extent: int
    value_extent: int
    gradient_sums: Ints
    value_sums: Ints
    nowhere: Ints
    cleared: Ints
    cleared_ends: Ints


def plan_shares(
    groups: Sequence[Group],
    entities: Sequence[Entity],
    pattern: BlockPattern,
    placements: Sequence[Placement],
    trash: int,
    execution: Execution,
) -> Shares:
    """Split the instances of all groups; the same split for the same plan, always.

    Parameters
    ----------
    pattern, placements, trash : of the `ScatterPlan`
    """
    widths, free, stores = execution
    work = _work(groups, placements, execution)
    orders = tuple(
        order_of(group, p.rows, p.block_at, pattern.value_count)
        for group, p in zip(groups, placements, strict=True)
    )
    found, count = None, _count(sum(work))
    by_order = [p.arrays(o) for p, o in zip(placements, orders, strict=True)] if count > 1 else []
    while found is None and count > 1:
        bounds = tuple(
            _bounds(len(p.rows), width, count if one >= GRAIN else 1, count)
            for p, width, one in zip(placements, widths, work, strict=True)
        )
        limit = (_ROOM if count <= SHARES else _WIDE_ROOM) * pattern.value_count
        found = copies_of(by_order, widths, bounds, free, pattern, trash, limit)
        if found is None:
            count //= 2
    if found is None:
        whole = [
            lane_targets(p.in_order(), width, order, group.lead)
            for p, width, order, group in zip(placements, widths, orders, groups, strict=True)
        ]
        return _whole(groups, entities, pattern, placements, trash, execution, orders, whole)
    placed = [
        lane_targets(arrays, width, None, group.lead)
        for arrays, width, group in zip(found.placed, widths, groups, strict=True)
    ]
    firsts = plan_firsts(
        groups,
        entities,
        [lanes[2:4] for lanes in placed],
        [len(p.rows) for p in placements],
        # Places belong to one share each, where groups take turns; what is left whole comes last.
        sorted(range(len(groups)), key=lambda g: not free[g]),
        stores,
        found.nowhere,
        found.value_extent,
        count,
    )
    read_only(*bounds, *(o for o in orders if o is not None), *firsts.first)
    read_only(found.gradient_sums, found.value_sums, found.nowhere, firsts.cleared, firsts.ends)
    return Shares(
        count,
        bounds,
        orders,
        tuple(LaneTargets(*lanes, one) for lanes, one in zip(placed, firsts.first, strict=True)),
        found.gradient_extent,
        found.value_extent,
        found.gradient_sums,
        found.value_sums,
        found.nowhere,
        firsts.cleared,
        firsts.ends,
    )


def edited_shares(
    groups: Sequence[Group],
    entities: Sequence[Entity],
    pattern: BlockPattern,
    placements: Sequence[Placement],
    trash: int,
    execution: Execution,
    known: Shares,
    same: Sequence[int | None],
) -> Shares:
    """What `plan_shares` gives, from the shares of an earlier plan with the same pattern.

    Parameters
    ----------
    known : the earlier shares
    same : per group, instances from the first on that are placed as before; None: all are
    """
    if known.count > 1 or _count(sum(_work(groups, placements, execution))) > 1:
        return plan_shares(groups, entities, pattern, placements, trash, execution)
    orders: list[Ints | None] = []
    placed: list[_Placed] = []
    for group, p, width, order, lanes, first in zip(
        groups, placements, execution.widths, known.orders, known.placed, same, strict=True
    ):
        if first is None:
            orders.append(order)
            placed.append(lanes[:-1])
            continue
        now = order_of(group, p.rows, p.block_at, pattern.value_count)
        kept = first // width if order is None and now is None else 0
        orders.append(now)
        placed.append(lane_targets(p.in_order(), width, now, group.lead, lanes, kept))
    return _whole(groups, entities, pattern, placements, trash, execution, tuple(orders), placed)


def _whole(
    groups: Sequence[Group],
    entities: Sequence[Entity],
    pattern: BlockPattern,
    placements: Sequence[Placement],
    trash: int,
    execution: Execution,
    orders: tuple[Ints | None, ...],
    placed: Sequence[_Placed],
) -> Shares:
    """A problem that is not split: one share, without copies and what is added at the end.

    Parameters
    ----------
    placed : per group, its `LaneTargets` without `first`
    """
    extent = pattern.value_count + trash**2
    nowhere = np.array([pattern.value_count], dtype=np.int64)
    if extent <= _CACHED:
        # All values are zeroed and every contribution is added.
        first = [np.zeros(lanes[2].shape[:2], dtype=np.uint8) for lanes in placed]
        cleared, ends = np.array([[0, extent]], dtype=np.int64), _ONE
    else:
        counts, order = [len(p.rows) for p in placements], range(len(groups))
        targets = [lanes[2:4] for lanes in placed]
        firsts = plan_firsts(
            groups, entities, targets, counts, order, execution.overwrites, nowhere, extent, 1
        )
        first, cleared, ends = firsts.first, firsts.cleared, firsts.ends
    bounds = tuple([np.array([0, len(lanes[0])], dtype=np.int64) for lanes in placed])
    read_only(nowhere, cleared, ends, *bounds, *first, *(o for o in orders if o is not None))
    return Shares(
        1,
        bounds,
        orders,
        tuple([LaneTargets(*lanes, one) for lanes, one in zip(placed, first, strict=True)]),
        pattern.size + trash,
        extent,
        _NONE,
        _NONE,
        nowhere,
        cleared,
        ends,
    )


def _work(
    groups: Sequence[Group], placements: Sequence[Placement], execution: Execution
) -> list[float]:
    """Predicted nanoseconds of a linearisation of each group, 0 where threads may not share it."""
    return [
        _nanoseconds(group) * len(p.rows) if may else 0.0
        for group, p, may in zip(groups, placements, execution.concurrent, strict=True)
    ]


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
    ends = np.arange(count + 1, dtype=np.int64) * blocks // count
    return ends if parts > 1 else np.where(np.arange(count + 1) > 0, blocks, 0).astype(np.int64)
