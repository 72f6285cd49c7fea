"""The order in which kernels process instances: by shared rows, whose sums stay in registers."""

from __future__ import annotations

from arael.runtime.assembly.compiled import keys_of, order_by
from arael.runtime.layout import Group
from arael.runtime.store.access import Array, Ints
from arael.runtime.store.compiled import spread_rows

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
    return order_by(keys_of(rows, group.lead[0], block_at, group.lead_pairs, nowhere))


def in_lanes(values: Array, lanes: int, order: Array | None = None) -> Array:
    """(n, k) in lane order [blocks][k][lanes], the last block padded by the last instance."""
    # Aligned to cache lines, so that no register of lanes is read from two of them; a single block,
    # of which there may be hundreds, does without.
    return spread_rows(values, lanes, order)
