"""The block pattern of a symmetric matrix: coupled pairs and offsets of their blocks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.assembly.compiled import pattern_arrays, places_of

Ints = NDArray[np.int64]


@dataclass(eq=False)  # not frozen: its constructor would take three times as long
class BlockPattern:
    """Lower triangle of a symmetric block matrix by block columns.

    Block ``(i, j)`` with ``i >= j`` has ``sizes[i] x sizes[j]`` scalars, row-major and contiguous
    in the array of values from ``value_start`` on. Of a diagonal block only the lower triangle
    (row >= column) is meaningful; the rest of its square must not be read.

    Attributes
    ----------
    sizes : (nb,) int64
        Scalars of each block row.
    column_start : (nb + 1,) int64
        Blocks of column ``j`` are ``column_start[j]:column_start[j + 1]``, the diagonal first.
    rows : (nblocks,) int64
        Block row of each block, ascending within a column.
    value_start : (nblocks,) int64
        Offset of each block's first scalar in the array of values.
    name_of : callable
        Name of scalar ``i`` in the model (``poses[3].ea.z``), for messages.
    by_rows : bool
        Whether the values lie by block rows, not by columns.
    """

    sizes: Ints
    column_start: Ints
    rows: Ints
    value_start: Ints
    name_of: Callable[[int], str] = field(default=lambda i: f"x[{i}]", compare=False)
    # Symbolic factors by ordering, as far as they were computed; see `analysis.analyse`.
    known: dict[str, Any] = field(default_factory=dict, compare=False, repr=False)
    by_rows: bool = field(default=False, compare=False, repr=False)

    @property
    def block_count(self) -> int:
        """Number of block rows."""
        return len(self.sizes)

    @cached_property
    def offsets(self) -> Ints:
        """(nb + 1,) first scalar of each block row."""
        return np.concatenate(([0], np.cumsum(self.sizes)))

    @cached_property
    def size(self) -> int:
        """Number of scalar rows."""
        return int(self.sizes.sum())

    @cached_property
    def value_count(self) -> int:
        """Length of the array of values."""
        # As many scalars as all block columns have: each is as wide as its entity.
        if not len(self.rows):
            return 0
        heights = np.add.reduceat(self.sizes[self.rows], self.column_start[:-1])
        return int(heights @ self.sizes)

    @cached_property
    def places(self) -> Ints:
        """(nblocks, 5) first scalar row, first scalar column, height, width and `value_start`."""
        return places_of(self)

    def same_as(self, other: BlockPattern) -> bool:
        """Whether both have the same blocks with the same sizes and offsets."""
        return self is other or (
            np.array_equal(self.sizes, other.sizes)
            and np.array_equal(self.column_start, other.column_start)
            and np.array_equal(self.rows, other.rows)
        )

    @classmethod
    def from_pairs(
        cls,
        sizes: Ints,
        rows: Ints,
        columns: Ints,
        name_of: Callable[[int], str] | None = None,
        by_rows: bool = False,
    ) -> BlockPattern:
        """Build from coupled pairs in any order; diagonal blocks are always included.

        `by_rows` orders the values by block rows instead of columns, for sequential memory access
        of the writer.
        """
        nb = len(sizes)
        low = np.minimum(rows, columns).astype(np.int64)
        high = np.maximum(rows, columns).astype(np.int64)
        return cls.from_keys(sizes, low * nb + high, name_of, by_rows)

    @classmethod
    def from_keys(
        cls,
        sizes: Ints,
        keys: Ints,
        name_of: Callable[[int], str] | None = None,
        by_rows: bool = False,
    ) -> BlockPattern:
        """Build from ``lower * nb + higher`` of coupled pairs in any order; see `from_pairs`."""
        sizes = np.ascontiguousarray(sizes, dtype=np.int64)
        keys = keys.copy()
        keys.sort()
        start, rows, places, offsets, size, count = pattern_arrays(sizes, keys, by_rows)
        found = cls(sizes, start, rows, places, by_rows=by_rows)
        # As the cached properties keep them.
        found.__dict__.update(value_count=count, offsets=offsets, size=size)
        if name_of is not None:
            found.name_of = name_of
        return found

    def find(self, rows: Ints, columns: Ints) -> Ints:
        """Offset in the values of each block ``(max, min)`` of the given pairs; all must exist."""
        nb = len(self.sizes)
        low, high = np.minimum(rows, columns), np.maximum(rows, columns)
        column = np.repeat(np.arange(nb), np.diff(self.column_start))
        keys = column * nb + self.rows
        found = np.searchsorted(keys, low * nb + high)
        return self.value_start[found]
