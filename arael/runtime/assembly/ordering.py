"""The order in which kernels process instances: by shared rows, whose sums stay in registers."""

from __future__ import annotations

import numpy as np

from arael.runtime.layout import Group, pair_of
from arael.runtime.store.access import Array, Ints

# Instances too few to fill two blocks of lanes need no order.
_FEW = 16


def order_of(group: Group, rows: Array, block_at: Ints, nowhere: int) -> Ints | None:
    """Instances by the row of the group's lead, otherwise as they come.

    Of a row, those come last that meet what another one has met already: a landmark that a second
    camera sees from the same pose. So those before can be the first to write their blocks.

    Parameters
    ----------
    rows : (n, uses) row of each used entity
    block_at : (n, pairs) where in the values each pair's block is
    nowhere : where it is if it is not solved for

    Returns
    -------
    (n,) instances in their order; None: as they come
    """
    if not group.lead or len(rows) < _FEW:
        return None
    lead = rows[:, group.lead[0]].astype(np.int64)
    keys = 2 * lead + _met(group, block_at, nowhere)
    if not (keys[1:] < keys[:-1]).any():
        return None
    # Counting sort for short keys.
    return np.argsort(keys.astype(np.uint16) if keys.max() < 2**16 else keys, kind="stable")


def _met(group: Group, block_at: Ints, nowhere: int) -> Array:
    """(n,) bool, whether an earlier instance has the same block with the lead."""
    lead = group.lead[0]
    others = [pair_of(u, lead) for u in range(len(group.uses))]
    met = np.zeros(len(block_at), dtype=bool)
    for pair in others[:lead] + others[lead + 1 :]:
        at = block_at[:, pair]
        if (at == nowhere).all():
            continue
        order = np.argsort(at, kind="stable")
        met[order[1:]] = np.diff(at[order]) == 0
        met &= at != nowhere
        break
    return met


def runs(rows: Array, n: int) -> Array:
    """(blocks,) uint8, whether all lanes of a block are instances of the same rows.

    Parameters
    ----------
    rows : (blocks, uses, lanes) rows of the uses that lead, none if there are no such uses
    n : instances; a block that is padded does not count
    """
    blocks, uses, lanes = rows.shape
    if uses == 0:
        return np.zeros(blocks, dtype=np.uint8)
    same: Array = (rows == rows[:, :, :1]).all(axis=(1, 2)).astype(np.uint8)
    same[n // lanes :] = 0
    return same
