"""Where single scalars of the system lie in the values of its blocks."""

from __future__ import annotations

import numpy as np

from arael.runtime.assembly.compiled import diagonal_of, rows_and_columns
from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.store.access import Array, Bools, Ints


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
    return rows_and_columns(pattern, scalars)


def dense_matrix(pattern: BlockPattern, values: Array) -> Array:
    """(n, n) f64, both triangles, from the lower one in `values`."""
    row, column = coordinates(pattern)
    lower: Bools = row >= column
    found = np.zeros((pattern.size, pattern.size))
    found[row[lower], column[lower]] = values[lower]
    found[column[lower], row[lower]] = values[lower]
    return found
