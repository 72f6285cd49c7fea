"""First writers: the blocks of J'J that a kernel overwrites instead of adding to them.

Most off-diagonal blocks have a single instance: an observation of a landmark from a pose. First
writers overwrite, so such blocks need neither zeroing nor reading, which is half of the memory
traffic of a linearisation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.layout import Entity, Group, pair_of

Ints = NDArray[np.int64]

# Stored blocks so close to others that are emptied are emptied with them, in scalars.
_NEAR = 64

# Scalars of a cache line.
_LINE = 16

# Of `turn`: onto a diagonal block, of which there is more than the pair's own.
_DIAGONAL = 2


@dataclass(frozen=True)
class Firsts:
    """First writers, and the ranges that must be zeroed for the others.

    Attributes
    ----------
    first : per group (blocks, pairs) uint8
        Whether all lanes of a block of lanes are the first to write the pair's block.
    cleared : (m, 2) int64, begin and end of what must be emptied
    ends : (parts + 1,) int64, rows of `cleared` that make up equal parts
    """

    first: list[NDArray[np.uint8]]
    cleared: Ints
    ends: Ints


def plan_firsts(
    groups: Sequence[Group],
    entities: Sequence[Entity],
    placed: Sequence[list[NDArray[Any]]],
    counts: Sequence[int],
    order: Sequence[int],
    may: Sequence[bool],
    nowhere: Ints,
    room: int,
    parts: int,
) -> Firsts:
    """Find the first writers of all blocks.

    Parameters
    ----------
    placed : per group, block_at and turn (blocks, pairs, lanes) in lane order
    counts : instances by group
    order : groups in the order in which they write any one place
    may : by group, whether it may store
    nowhere : where what is not solved for goes
    room : scalars of the values
    parts : in how many the emptying is shared
    """
    first = [np.zeros(p[0].shape[:2], dtype=np.uint8) for p in placed]
    writes: list[tuple[int, int, int]] = []  # group, pair, area of its block
    ats, seqs, keys = [], [], []
    step = 0
    for g in order:
        block_at, turn = placed[g]
        blocks, _, lanes = block_at.shape
        real = np.arange(blocks * lanes).reshape(blocks, lanes) < counts[g]
        tangent = [entities[use.entity].tangent for use in groups[g].uses]
        for a in range(len(tangent)):
            for b in range(a):
                pair = pair_of(a, b)
                at = block_at[:, pair]
                counted = real & ~np.isin(at, nowhere)
                if not counted.any():
                    continue
                ats.append(at[counted])
                at_block = np.broadcast_to(np.arange(blocks)[:, None], at.shape)[counted]
                seqs.append(step + at_block)
                keys.append(np.full(len(at_block), len(writes), dtype=np.int32))
                writes.append((g, pair, tangent[a] * tangent[b]))
                if may[g]:
                    first[g][:, pair] = (~counted | (turn[:, pair] != _DIAGONAL)).all(axis=1)
        step += blocks
    if not writes:
        return Firsts(first, *_cut(np.array([[0, room]], dtype=np.int64), parts))
    at, seq, key = np.concatenate(ats), np.concatenate(seqs), np.concatenate(keys)
    alone = _alone_and_first(at, seq)
    starts, areas = [], []
    steps = np.zeros(len(groups), dtype=np.int64)
    steps[list(order)] = np.cumsum([0, *(len(first[g]) for g in order)])[:-1]
    ends = np.searchsorted(key, np.arange(len(writes) + 1))
    for k, (g, pair, area) in enumerate(writes):
        mine = slice(ends[k], ends[k + 1])
        at_block = seq[mine] - steps[g]
        first[g][at_block[~alone[mine]], pair] = 0
        stored = at[mine][first[g][at_block, pair] == 1]
        starts.append(stored)
        areas.append(np.full(len(stored), area, dtype=np.int64))
    cleared = _between(np.concatenate(starts), np.concatenate(areas), room)
    return Firsts(first, *_cut(cleared, parts))


def _alone_and_first(at: Ints, seq: Ints) -> NDArray[np.bool_]:
    """Whether each write is the first to its place, and the only one of its block of lanes."""
    order = np.lexsort((seq, at))
    place, turn = at[order], seq[order]
    opens = np.diff(place, prepend=-1) != 0
    # The next write is to the same place, by the same block of lanes.
    again = np.append(~opens[1:] & (turn[1:] == turn[:-1]), False)
    found = np.zeros(len(at), dtype=bool)
    found[order] = opens & ~again
    return found


def _between(starts: Ints, areas: Ints, room: int) -> Ints:
    """(m, 2) what lies between stored blocks, short ones of these included."""
    order = np.argsort(starts, kind="stable")
    begins = np.append(starts[order], room)
    ends = np.concatenate(([0], (starts + areas)[order]))
    # A run of stored blocks is left out if it is long; otherwise it is emptied like the rest.
    gap = begins > ends
    gap[0] = gap[-1] = True
    low, high = ends[gap], begins[gap]
    joined = low[1:] - high[:-1] < _NEAR
    found: Ints = np.stack(
        (low[np.concatenate(([True], ~joined))], high[np.concatenate((~joined, [True]))]), axis=1
    )
    return found[found[:, 0] < found[:, 1]]


def _cut(ranges: Ints, parts: int) -> tuple[Ints, Ints]:
    """The ranges cut where equal parts of them begin, and the first range of each part."""
    if not len(ranges):
        return ranges, np.zeros(parts + 1, dtype=np.int64)
    lengths = ranges[:, 1] - ranges[:, 0]
    done = np.concatenate(([0], np.cumsum(lengths)))
    shares = done[-1] * np.arange(1, parts) // parts
    at = np.searchsorted(done, shares, side="right") - 1
    cuts = ranges[at, 0] + (shares - done[at])
    cuts = np.minimum(-(-cuts // _LINE) * _LINE, ranges[at, 1])
    begins = np.unique(np.concatenate((ranges[:, 0], cuts)))
    last = np.searchsorted(ranges[:, 0], begins, side="right") - 1
    ends = np.minimum(np.append(begins[1:], ranges[-1, 1]), ranges[last, 1])
    kept = begins < ends
    begins, ends = begins[kept], ends[kept]
    rows = np.concatenate(([0], np.searchsorted(begins, cuts), [len(begins)]))
    cleared: Ints = np.ascontiguousarray(np.stack((begins, ends), axis=1))
    return cleared, rows.astype(np.int64)
