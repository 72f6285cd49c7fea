"""The system of the boundary: the sum of what the parts contribute, and its solution."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.assembly.positions import coordinates, diagonal_positions
from arael.runtime.linear.auto import make_solver
from arael.runtime.linear.compiled import LinearSolver

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Boundary:
    """Blocks between parts, and where each part contributes to their system.

    Attributes
    ----------
    sizes : (blocks,) int64, scalars of each block
    of_part : per part, its boundary blocks in its own order, as numbers of blocks here
    """

    sizes: Ints
    of_part: tuple[Ints, ...]

    @property
    def size(self) -> int:
        """Number of scalars."""
        return int(self.sizes.sum())

    def scalars(self, blocks: Ints) -> Ints:
        """Scalars of some blocks, block by block."""
        offsets = np.concatenate(([0], np.cumsum(self.sizes)))
        return scalars_of(offsets, blocks)


def scalars_of(offsets: Ints, blocks: Ints) -> Ints:
    """Scalars of some blocks that begin at `offsets` (all blocks + 1,), block by block."""
    sizes = offsets[blocks + 1] - offsets[blocks]
    first = np.repeat(offsets[blocks] - (np.cumsum(sizes) - sizes), sizes)
    return np.asarray(first + np.arange(int(sizes.sum())), dtype=np.int64)


class BoundarySystem:
    """Sparse system of the boundary: parts couple their own boundary blocks only.

    Its solver orders the blocks as it does any system, so that separators of separators are
    eliminated as in a tree.
    """

    def __init__(self, boundary: Boundary) -> None:
        self.boundary = boundary
        pairs = [np.zeros((0, 2), dtype=np.int64)]
        for blocks in boundary.of_part:
            one, other = np.meshgrid(blocks, blocks, indexing="ij")
            below = one > other
            pairs.append(np.stack((one[below], other[below]), axis=1))
        every = np.unique(np.concatenate(pairs), axis=0)
        self.pattern = BlockPattern.from_pairs(boundary.sizes, every[:, 0], every[:, 1])
        self.solver: LinearSolver = make_solver("auto", self.pattern)
        self._diagonal_at = diagonal_positions(self.pattern)
        row, column = coordinates(self.pattern)
        self._entries = []
        for blocks in boundary.of_part:
            scalars = boundary.scalars(blocks)
            place = np.full(boundary.size, -1, dtype=np.int64)
            place[scalars] = np.arange(len(scalars))
            at = np.flatnonzero((place[row] >= 0) & (place[column] >= 0))
            self._entries.append((scalars, at, place[row[at]], place[column[at]]))

    def factorise(self, parts: Sequence[Floats | None], added: Floats) -> int:
        """Factorise the sum of the parts' S with `added` (n,) on its diagonal.

        None is a part that adds nothing.
        """
        values = np.zeros(self.pattern.value_count)
        for one, (_, at, row, column) in zip(parts, self._entries, strict=True):
            if one is not None:
                values[at] += one[row, column]
        return int(self.solver.factorise(values, values[self._diagonal_at] + added))

    def solve(self, parts: Sequence[Floats | None], right: Floats) -> Floats:
        """Solution for the right-hand side (n,), with what the parts' sweeps add to it."""
        whole = np.array(right)
        for one, (scalars, *_) in zip(parts, self._entries, strict=True):
            if one is not None:
                whole[scalars] += one
        return np.asarray(self.solver.solved(whole))
