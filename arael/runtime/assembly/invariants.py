"""The invariants of a scatter plan, checked on its arrays alone.

They are checked by tests, and by `ScatterPlan.check` where a wrong sum is suspected; no solve does.

Pattern
    ``triangle``: each symmetric pair of blocks occurs once, in the lower triangle, and each column
    begins with its diagonal block. ``tiles``: the blocks fill the values without gap or overlap.
Placements, per instance
    ``active``: exactly the active instances have offsets, and each is active once. ``gradient``: a
    use adds to the first scalar of its row's block, or behind the gradient. ``blocks``: a pair of
    uses adds to the block of their rows, in the right orientation, or behind the values.
Shares, in lane order
    ``partition``: each instance is in exactly one block of lanes and each block in exactly one
    share. ``offsets``: a lane adds where its instance does, or to a copy that is added there once.
    ``copies``: copies and trash lie behind the arrays' own scalars and do not overlap.
    ``separate``: no two shares write to the same block at the same time. ``firsts``: a first writer
    overwrites before all others, once. ``cleared``: what no first writer overwrites is zeroed once.
    ``runs``: lanes that are marked as a run have the same rows of the lead.
All
    ``read-only``: no array can be written.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.assembly.placement import Placement
from arael.runtime.layout import Entity, Group, pair_of

Ints = NDArray[np.int64]

STRAIGHT, TRANSPOSED, DIAGONAL = 0, 1, 2
"""Values of `Placement.turn`."""


class BrokenPlan(Exception):
    """An invariant of a scatter plan does not hold: an error in arael.

    Attributes
    ----------
    invariant : its name in `arael.runtime.assembly.invariants`
    """

    def __init__(self, invariant: str, message: str) -> None:
        super().__init__(f"{invariant}: {message}")
        self.invariant = invariant


def require(holds: Any, invariant: str, message: str) -> None:
    """Raise `BrokenPlan` unless all of `holds` is true."""
    if not np.all(holds):
        raise BrokenPlan(invariant, message)


def require_read_only(*arrays: NDArray[Any]) -> None:
    """Raise `BrokenPlan` if an array can be written."""
    require(not any(a.flags.writeable for a in arrays), "read-only", "an array can be written")


def columns_of(pattern: BlockPattern) -> Ints:
    """Block column of each block."""
    return np.repeat(np.arange(pattern.block_count), np.diff(pattern.column_start))


def check_pattern(pattern: BlockPattern) -> None:
    """Check ``triangle`` and ``tiles``."""
    require_read_only(pattern.sizes, pattern.column_start, pattern.rows, pattern.value_start)
    nb, start, rows = pattern.block_count, pattern.column_start, pattern.rows
    require(
        len(start) == nb + 1 and start[0] == 0 and start[-1] == len(rows), "triangle", "columns"
    )
    require(np.diff(start) >= 1, "triangle", "a column has no diagonal block")
    columns = columns_of(pattern)
    require(rows[start[:-1]] == np.arange(nb), "triangle", "a diagonal block is not the first")
    inside = (rows >= columns) & (rows < nb)
    require(inside, "triangle", "a block is not in the lower triangle")
    key = columns * nb + rows
    require(np.diff(key) > 0, "triangle", "a pair occurs twice, or rows do not ascend")
    areas = pattern.sizes[rows] * pattern.sizes[columns]
    order = np.argsort(pattern.value_start, kind="stable")
    # Blocks without scalars take no place.
    order = order[areas[order] > 0]
    ends = np.cumsum(areas[order])
    require(
        pattern.value_start[order] == ends - areas[order], "tiles", "blocks overlap or leave gaps"
    )
    require(pattern.value_count == areas.sum(), "tiles", "the number of values is wrong")


def check_placements(
    groups: Sequence[Group],
    entities: Sequence[Entity],
    active: Sequence[Ints],
    pattern: BlockPattern,
    placements: Sequence[Placement],
    trash: int,
) -> None:
    """Check ``active``, ``gradient`` and ``blocks``."""
    require(
        len(groups) == len(active) == len(placements),
        "active",
        "groups without instances or offsets",
    )
    require(
        trash >= max((e.tangent for e in entities), default=1), "gradient", "the trash is too small"
    )
    # First scalar of each row, the same wherever a row of an entity is used.
    rows_of: dict[int, dict[int, int]] = {}
    for group, rows, p in zip(groups, active, placements, strict=True):
        require_read_only(rows, p.rows, p.gradient_at, p.block_at, p.turn)
        n, uses = len(rows), len(group.uses)
        require(np.diff(rows) > 0, "active", f"instances of `{group.label}` do not ascend")
        shapes = p.rows.shape, p.gradient_at.shape, p.block_at.shape, p.turn.shape
        pairs = uses * (uses + 1) // 2
        require(
            shapes == ((n, uses), (n, uses), (n, pairs), (n, pairs)),
            "active",
            f"`{group.label}` has offsets of other instances than the active ones",
        )
        for u, use in enumerate(group.uses):
            at, width = p.gradient_at[:, u], entities[use.entity].tangent
            solved = at != pattern.size
            block = np.searchsorted(pattern.offsets, at[solved], side="right") - 1
            require(
                (at >= 0) & (at <= pattern.size),
                "gradient",
                f"use {u} of `{group.label}` is out of range",
            )
            require(
                (pattern.offsets[block] == at[solved]) & (pattern.sizes[block] == width),
                "gradient",
                f"use {u} of `{group.label}` is not at the first scalar of a block of its entity",
            )
            known = rows_of.setdefault(use.entity, {})
            both = zip(p.rows[:, u].tolist(), at.tolist(), strict=True)
            require(
                all(known.setdefault(row, first) == first for row, first in both),
                "gradient",
                f"a row of use {u} of `{group.label}` has another block elsewhere",
            )
        _check_blocks(group, pattern, p)


def _check_blocks(group: Group, pattern: BlockPattern, p: Placement) -> None:
    columns = columns_of(pattern)
    nb, nowhere = pattern.block_count, pattern.value_count
    keys = columns * nb + pattern.rows
    block = np.searchsorted(pattern.offsets, p.gradient_at, side="right") - 1
    solved = p.gradient_at != pattern.size
    together = _coupled(group)
    for a in range(len(group.uses)):
        for b in range(a + 1):
            pair = pair_of(a, b)
            at, turn = p.block_at[:, pair], p.turn[:, pair]
            both = solved[:, a] & solved[:, b] & ((a, b) in together)
            require(
                (at[~both] == nowhere) & (turn[~both] == STRAIGHT),
                "blocks",
                f"pair {a}, {b} of `{group.label}` is not solved for and has a block",
            )
            i, j = block[both, a], block[both, b]
            wanted = np.minimum(i, j) * nb + np.maximum(i, j)
            found = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
            require(
                (keys[found] == wanted) & (pattern.value_start[found] == at[both]),
                "blocks",
                f"pair {a}, {b} of `{group.label}` is not at the block of its rows",
            )
            expected = np.where(
                i == j, STRAIGHT if a == b else DIAGONAL, np.where(i < j, TRANSPOSED, STRAIGHT)
            )
            require(
                turn[both] == expected,
                "blocks",
                f"pair {a}, {b} of `{group.label}` has the wrong orientation",
            )


def _coupled(group: Group) -> set[tuple[int, int]]:
    """Pairs of uses that some residual reads together, and every use with itself."""
    reads: dict[int, set[int]] = {}
    for residual, use, _ in group.jacobian:
        reads.setdefault(residual, set()).add(use)
    found = {(u, u) for u in range(len(group.uses))}
    for uses in reads.values():
        found |= {(a, b) for a in uses for b in uses if a >= b}
    return found
