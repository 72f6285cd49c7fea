"""Offsets of the blocks of a matrix in the storage of its multifrontal factor."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.linear.blocks import table_of
from arael.runtime.linear.fronts import Fronts
from arael.runtime.linear.memory import leading
from arael.runtime.linear.supernodes import Supernodes

Ints = NDArray[np.int64]


def place_blocks(
    pattern: BlockPattern, supernodes: Supernodes, fronts: Fronts, pad: int
) -> tuple[Ints, Ints]:
    """Place the blocks of `pattern` in the fronts.

    Parameters
    ----------
    pattern : BlockPattern
    supernodes : Supernodes
    fronts : Fronts
    pad : int
        Scalars that rows are padded to a multiple of.

    Returns
    -------
    front_start : (ns + 1,) int64
        Blocks of front s are ``front_start[s]:front_start[s + 1]``.
    blocks : (nblocks, 4) int64
        Table for `arael.runtime.linear.blocks.put`.
    """
    nb = pattern.block_count
    ns = len(supernodes.parent)
    columns = np.repeat(np.arange(nb, dtype=np.int64), np.diff(pattern.column_start))
    position = np.empty(nb, dtype=np.int64)
    position[supernodes.order] = np.arange(nb)
    offset = np.concatenate(([0], np.cumsum(pattern.sizes[supernodes.order]))).astype(np.int64)
    owner = np.repeat(np.arange(ns), np.diff(supernodes.start))

    low = np.minimum(position[pattern.rows], position[columns])
    high = np.maximum(position[pattern.rows], position[columns])
    front = owner[low]
    column = offset[low] - fronts.first[front]
    inside = high < supernodes.start[front + 1]
    # Rows below: looked up in all fronts' lists at once, by front and position.
    owners = np.repeat(np.arange(ns), np.diff(supernodes.row_start))
    at = np.searchsorted(owners * nb + supernodes.rows, front * nb + high)
    width = pattern.sizes[supernodes.order]
    before = np.concatenate(([0], np.cumsum(width[supernodes.rows])))
    row_below = before[at] - before[supernodes.row_start[front]]
    apart = leading(np.where(inside, fronts.columns[front], fronts.below[front] + 1), pad)
    row = np.where(inside, offset[high] - fronts.first[front], row_below)
    place = np.where(inside, fronts.triangle[front], fronts.panel[front]) + row + column * apart
    how = np.where(low == high, 2, (position[pattern.rows] < position[columns]).astype(np.int64))
    height, wide = pattern.sizes[pattern.rows], pattern.sizes[columns]
    blocks = table_of(pattern.value_start, height, wide, place, apart, how)
    sequence = np.lexsort((column, front))
    starts = np.searchsorted(front[sequence], np.arange(ns + 1)).astype(np.int64)
    return starts, blocks[sequence]
