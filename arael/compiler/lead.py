"""The lead of a constraint: uses whose rows many instances in a row share, once sorted."""

from __future__ import annotations

from collections.abc import Sequence

from arael.runtime.layout import Slot, Use


def leading(
    uses: Sequence[Use], slots: Sequence[Slot], tables: Sequence[str], tangents: Sequence[int]
) -> tuple[int, ...]:
    """Choose the largest use that instances share, then those of the root, which all share.

    A use whose rows differ for all instances cannot lead; nor can one of two uses of the same
    entity, because sorting by one of them does not sort by the other.

    Parameters
    ----------
    uses, slots : of the constraint
    tables, tangents : by entity: its table, and the scalars solved for in a row
    """
    roots = [u for u, use in enumerate(uses) if not tables[use.entity]]
    kinds = [use.entity for use in uses]
    shared = [
        u
        for u, use in enumerate(uses)
        if u not in roots and slots[use.slot].steps and kinds.count(use.entity) == 1
    ]
    largest = max(shared, key=lambda u: (tangents[kinds[u]], -u), default=None)
    return (*([] if largest is None else [largest]), *roots)
