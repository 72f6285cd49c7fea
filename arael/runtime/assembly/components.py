"""Connected components of a problem: what is solved together, but has nothing to do with the rest.

Rows that are solved for are joined by active instances that read two or more of them. Instances of
one component depend on its rows only, so that its steps can be judged by their costs alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arael.runtime.assembly.compiled import connected, labels_of_instances, runs_of_values
from arael.runtime.assembly.structure import Structure
from arael.runtime.layout import Group

Ints = NDArray[np.int64]
Labels = NDArray[np.int32]


@dataclass(frozen=True)
class Partition:
    """The components of a problem that has at least two.

    They are numbered in the order of their first blocks in the system. Blocks in which nothing
    moves join nothing; they have the number 0, and take no step there.

    Attributes
    ----------
    count : components
    of_block : (nb,) int32, component of each block of the system
    of_scalar : (n,) int32, component of each scalar of the system
    of_instance : per group (instances,) int32, component of each active instance
        Those that read nothing that is solved for have the number `count`: their cost is constant.
    guarded : (count,) bool, whether a guard of an instance of each reads parameters
    of_values : (m, 3) int64, begin, end and component of runs of values of J'J
    first_block : (count,) int64, first block of each component
    block_counts : (count,) int64, blocks of each
    """

    count: int
    of_block: Labels
    of_scalar: Labels
    of_instance: tuple[Labels, ...]
    guarded: NDArray[np.bool_]
    of_values: Ints
    first_block: Ints
    block_counts: Ints


def partition_of(structure: Structure, groups: Sequence[Group]) -> Partition | None:
    """The components of a structure; None if there is only one, or nothing to solve for.

    Kept with the structure.
    """
    if not structure.partition:
        several = structure.pattern.block_count > 1
        structure.partition.append(
            _found(structure, groups, _idle(structure), 2) if several else None
        )
    found: Partition | None = structure.partition[0]
    return found


def any_partition_of(
    structure: Structure, groups: Sequence[Group], idle: NDArray[np.uint8]
) -> Partition:
    """The components of a structure, also where there is one or none.

    Parameters
    ----------
    idle : (nb,) uint8, blocks that join nothing and are of no component
    """
    found = _found(structure, groups, idle, 0)
    assert found is not None
    return found


def _found(
    structure: Structure, groups: Sequence[Group], idle: NDArray[np.uint8], least: int
) -> Partition | None:
    """The components, if there are `least` of them."""
    pattern = structure.pattern
    ones, others = _uncoupled(structure, groups)
    count, labels = connected(pattern.column_start, pattern.rows, ones, others, idle)
    if count < least:
        return None
    # All uses of an instance that are solved for are of one component.
    of_scalar = np.repeat(labels, pattern.sizes)
    moving = np.repeat(np.where(idle, -1, labels), pattern.sizes) if idle.any() else of_scalar
    instances = [
        labels_of_instances(one.gradient_at, moving, count) for one in structure.placements
    ]
    guarded = np.zeros(count + 1, dtype=bool)
    for group, found in zip(groups, instances, strict=True):
        if group.moving_guard is not None:
            guarded[found] = True
    return Partition(
        count,
        labels,
        of_scalar,
        tuple(instances),
        guarded[:count],
        runs_of_values(pattern.column_start, pattern.value_start, labels, pattern.value_count),
        np.flatnonzero(np.diff(np.maximum.accumulate(np.where(idle, -1, labels)), prepend=-1)),
        np.bincount(labels[idle == 0], minlength=count),
    )


def _idle(structure: Structure) -> NDArray[np.uint8]:
    """(nb,) whether nothing moves in a block, which a session keeps for when it does again."""
    found = np.zeros(structure.pattern.block_count, dtype=np.uint8)
    if structure.idle:
        for blocks in structure.system.blocks:
            found[blocks.block[(blocks.block >= 0) & ~blocks.solved]] = 1
    return found


def blocks_of(structure: Structure, group: int) -> Ints:
    """(instances, uses) block of each use, -1 where it is not solved for."""
    offsets = structure.pattern.offsets
    at = structure.placements[group].gradient_at
    found: Ints = np.searchsorted(offsets, at, side="right") - 1
    found[at >= offsets[-1]] = -1
    return found


def _uncoupled(structure: Structure, groups: Sequence[Group]) -> tuple[Ints, Ints]:
    """Pairs of blocks that an instance reads, but that no residual couples.

    They are no blocks of the pattern; the instance has one cost all the same.
    """
    ones: list[Ints] = []
    others: list[Ints] = []
    for number, group in enumerate(groups):
        if not group.uncoupled or not len(structure.placements[number].rows):
            continue
        blocks = blocks_of(structure, number)
        for a, b in group.uncoupled:
            both = (blocks[:, a] >= 0) & (blocks[:, b] >= 0)
            ones.append(blocks[both, a])
            others.append(blocks[both, b])
    if not ones:
        return (none := np.zeros(0, dtype=np.int64)), none
    return np.concatenate(ones), np.concatenate(others)


def graph_components(count: int, a: Ints, b: Ints) -> Ints:
    """Component of each node, named by its smallest node.

    Parameters
    ----------
    count : number of nodes
    a, b : (m,) nodes that each edge joins

    Returns
    -------
    (count,) int64
    """
    alone, nothing = np.zeros(count + 1, np.int64), np.zeros(0, np.int64)
    ends = np.ascontiguousarray(a, np.int64), np.ascontiguousarray(b, np.int64)
    found, labels = connected(alone, nothing, ends[0], ends[1], np.zeros(count, np.uint8))
    if found == 1:  # as most graphs are
        return np.zeros(count, np.int64)
    # Labels are numbered in order of their first nodes.
    top = np.maximum.accumulate(labels)
    new = np.ones(count, np.bool_)
    np.greater(top[1:], top[:-1], out=new[1:])
    first = np.flatnonzero(new)
    return np.asarray(first[labels], np.int64)
