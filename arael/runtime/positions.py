"""Where single scalars of the system lie in the values of its blocks."""

from __future__ import annotations

import numpy as np

from arael.runtime.access import Array, Bools, Ints
from arael.runtime.couplings import diagonal_of
from arael.runtime.linear.pattern import BlockPattern


def diagonal_positions(pattern: BlockPattern) -> Ints:
    """(n,) offset of each diagonal scalar."""
    return diagonal_of(pattern)


def coordinates(pattern: BlockPattern) -> tuple[Ints, Ints]:
    """Row and column of every value, (value_count,) each, squares of diagonal blocks whole."""
    in_memory = np.argsort(pattern.value_start)
    block_row = pattern.rows[in_memory]
    block_column = np.repeat(np.arange(pattern.block_count), np.diff(pattern.column_start))
    block_column = block_column[in_memory]
    height, width = pattern.sizes[block_row], pattern.sizes[block_column]
    lengths = height * width
    block = np.repeat(np.arange(len(lengths)), lengths)
    inner = np.arange(int(lengths.sum())) - np.repeat(pattern.value_start[in_memory], lengths)
    offsets = pattern.offsets
    row = offsets[block_row][block] + inner // width[block]
    column = offsets[block_column][block] + inner % width[block]
    return row, column


def row_and_column_positions(pattern: BlockPattern, scalars: Ints) -> tuple[Ints, Ints]:
    """Offsets of all values in the rows and columns of some scalars, their diagonals excepted.

    Returns
    -------
    start : (len(scalars) + 1,), where each scalar's offsets begin
    positions : the offsets
    """
    if len(scalars) == 0:
        return np.zeros(1, dtype=np.int64), np.zeros(0, dtype=np.int64)
    number = np.full(pattern.size, -1, dtype=np.int64)
    number[scalars] = np.arange(len(scalars))
    row, column = coordinates(pattern)
    off = row != column
    places = np.arange(len(row))
    owner = np.concatenate((number[row[off]], number[column[off]]))
    place = np.concatenate((places[off], places[off]))
    place, owner = place[owner >= 0], owner[owner >= 0]
    order = np.argsort(owner, kind="stable")
    start = np.searchsorted(owner[order], np.arange(len(scalars) + 1))
    return start.astype(np.int64), place[order].astype(np.int64)


def dense_matrix(pattern: BlockPattern, values: Array) -> Array:
    """(n, n) f64, both triangles, from the lower one in `values`."""
    row, column = coordinates(pattern)
    lower: Bools = row >= column
    found = np.zeros((pattern.size, pattern.size))
    found[row[lower], column[lower]] = values[lower]
    found[column[lower], row[lower]] = values[lower]
    return found
