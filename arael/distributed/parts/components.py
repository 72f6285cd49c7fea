"""Connected components of a problem in parts: joined from those of its parts.

A part knows which of its instances act, since it has their data. Its boundary entities join what it
finds with what other parts find.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arael.distributed.parts.shares import Share
from arael.runtime.assembly.compiled import runs_of_values
from arael.runtime.assembly.components import Partition, graph_components
from arael.runtime.assembly.pattern import BlockPattern

Ints = NDArray[np.int64]
Labels = NDArray[np.int32]
Bools = NDArray[np.bool_]


@dataclass(frozen=True)
class Joined:
    """The components of the whole, in the order of their first blocks.

    Attributes
    ----------
    of_block : (blocks,) int32, component of each block of the whole system
    of_part : per part (local components + 1,) int64, component of each of its components; the last
        is the number of components, for instances that read nothing that is solved for
    guarded : (components,) bool, whether a guard of an instance of each reads parameters
    """

    of_block: Labels
    of_part: tuple[Ints, ...]
    guarded: Bools

    @property
    def count(self) -> int:
        """Number of components."""
        return len(self.guarded)

    def partition(self, pattern: BlockPattern) -> Partition | None:
        """The components as the loop takes them; None if there is only one.

        Parameters
        ----------
        pattern : of the whole system, as far as the calling process has it
        """
        if self.count < 2:
            return None
        return Partition(
            self.count,
            self.of_block,
            np.repeat(self.of_block, pattern.sizes),
            (),
            self.guarded,
            runs_of_values(
                pattern.column_start, pattern.value_start, self.of_block, pattern.value_count
            ),
            np.unique(self.of_block, return_index=True)[1],
            np.bincount(self.of_block, minlength=self.count),
        )


def joined_components(
    shares: Sequence[Share], blocks: int, found: Sequence[tuple[Labels, Bools]]
) -> Joined:
    """The components of the whole.

    Parameters
    ----------
    blocks : number of blocks of the whole system
    found : per part the answer of `requests.components`
    """
    ones, others, first = [], [], blocks
    for share, (labels, guarded) in zip(shares, found, strict=True):
        read = share.interior | share.boundary
        ones.append(share.blocks[read])
        others.append(first + labels[read].astype(np.int64))
        first += len(guarded)
    one = np.concatenate([np.zeros(0, dtype=np.int64), *ones])
    other = np.concatenate([np.zeros(0, dtype=np.int64), *others])
    # Each is named by its first block, so that they are numbered as on one machine.
    firsts, labels_of = np.unique(graph_components(first, one, other)[:blocks], return_inverse=True)
    of_block = labels_of.astype(np.int32)
    count = len(firsts)
    guards = np.zeros(count, dtype=bool)
    of_part = []
    for share, (labels, guarded) in zip(shares, found, strict=True):
        read = share.interior | share.boundary
        own = np.full(len(guarded) + 1, count, dtype=np.int64)
        own[labels[read]] = of_block[share.blocks[read]]
        guards[own[:-1][guarded]] = True
        of_part.append(own)
    return Joined(of_block, tuple(of_part), guards)
