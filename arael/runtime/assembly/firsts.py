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

from arael.runtime.assembly.compiled import find_firsts
from arael.runtime.layout import Entity, Group

Ints = NDArray[np.int64]

# Stored blocks so close to others that are emptied are emptied with them, in scalars.
_NEAR = 64

# Scalars of a cache line.
_LINE = 16


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
    placed: Sequence[Sequence[NDArray[Any]]],
    counts: Sequence[int],
    order: Sequence[int],
    may: Sequence[bool],
    nowhere: Ints,
    extent: int,
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
    extent : scalars of the values
    parts : in how many the emptying is shared
    """
    found, between = find_firsts(
        [p[0] for p in placed],
        [p[1] for p in placed],
        counts,
        [_areas(group, entities) for group in groups],
        order,
        may,
        nowhere,
        extent,
        _NEAR,
    )
    return Firsts(found, *_cut(between, parts))


def _areas(group: Group, entities: Sequence[Entity]) -> list[int]:
    """Scalars of the block of each pair of uses; 0 of a use with itself."""
    tangent = [entities[use.entity].tangent for use in group.uses]
    return [
        tangent[a] * tangent[b] if a > b else 0 for a in range(len(tangent)) for b in range(a + 1)
    ]


def _cut(ranges: Ints, parts: int) -> tuple[Ints, Ints]:
    """The ranges cut where equal parts of them begin, and the first range of each part."""
    if not len(ranges):
        return ranges, np.zeros(parts + 1, dtype=np.int64)
    if parts == 1:
        return np.ascontiguousarray(ranges), np.array([0, len(ranges)], dtype=np.int64)
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
