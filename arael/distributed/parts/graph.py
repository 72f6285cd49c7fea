"""The graph of a problem: entities that are solved for, joined by the instances that read them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arael.runtime.layout import Group, Slot
from arael.runtime.store.access import StoreLike, Walker
from arael.runtime.system import System

Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Graph:
    """Vertices are the blocks of the system.

    Attributes
    ----------
    start, neighbours : undirected graph without loops, as `linear.symbolic.adjacency` makes it
    weights : (blocks,) int64, 1 + the number of instances that read each
    sizes : (blocks,) int64, scalars of each
    blocks : per group (instances, uses) int64, the block of each entity that an instance reads;
        -1 for one that is not solved for, or is behind a null ref
    """

    start: Ints
    neighbours: Ints
    weights: Ints
    sizes: Ints
    blocks: tuple[Ints, ...]

    @property
    def size(self) -> int:
        """Number of vertices."""
        return len(self.weights)


def graph_of(store: StoreLike, groups: Sequence[Group], system: System) -> Graph:
    """The graph of all rows of the tables of constraints, whether their guards hold or not.

    Guards over data need data; an edge too many makes a separator larger, and no result wrong.
    """
    count = len(system.sizes)
    blocks = tuple(_blocks_read(store, group, system) for group in groups)
    keys = [np.zeros(0, dtype=np.int64)]
    weights = np.ones(count, dtype=np.int64)
    for read in blocks:
        uses = read.shape[1]
        for a in range(uses):
            weights += np.bincount(read[:, a][read[:, a] >= 0], minlength=count)
            for b in range(a):
                low, high = np.minimum(read[:, a], read[:, b]), np.maximum(read[:, a], read[:, b])
                joined = (low >= 0) & (low != high)
                keys.append(np.unique(low[joined] * count + high[joined]))
    pairs = np.unique(np.concatenate(keys))
    low, high = pairs // max(count, 1), pairs % max(count, 1)
    one, other = np.concatenate((low, high)), np.concatenate((high, low))
    order = np.lexsort((other, one))
    start = np.searchsorted(one[order], np.arange(count + 1)).astype(np.int64)
    return Graph(start, other[order].astype(np.int64), weights, system.sizes, blocks)


def _blocks_read(store: StoreLike, group: Group, system: System) -> Ints:
    rows = np.arange(store.tables[group.table].size, dtype=np.int64)
    walker = Walker(store, group.table, rows, True)
    found = np.full((len(rows), len(group.uses)), -1, dtype=np.int64)
    for number, use in enumerate(group.uses):
        at = np.asarray(walker.rows(group.slots[use.slot]))
        block = system.blocks[use.entity].block
        there = at >= 0
        found[there, number] = block[at[there]]
    return found


def slots_on_the_way(group: Group) -> list[Slot]:
    """The slots of a group, and all rows on the ways there, each once."""
    found: dict[tuple[object, ...], Slot] = {}
    for slot in group.slots:
        for length in range(len(slot.steps) + 1):
            steps = slot.steps[:length]
            found.setdefault(steps, Slot(steps, ""))
    return list(found.values())
