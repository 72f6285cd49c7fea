"""The invariants of a scatter plan in lane order; `invariants.py` lists them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.assembly.invariants import DIAGONAL, require, require_read_only
from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.assembly.placement import Placement
from arael.runtime.assembly.shares import Execution, LaneTargets, Shares
from arael.runtime.layout import Entity, Group, pair_of

Ints = NDArray[np.int64]


def check_shares(
    groups: Sequence[Group],
    entities: Sequence[Entity],
    pattern: BlockPattern,
    placements: Sequence[Placement],
    trash: int,
    execution: Execution,
    shares: Shares,
) -> None:
    """Check ``partition`` to ``runs``."""
    require_read_only(
        *shares.bounds,
        *(order for order in shares.orders if order is not None),
        *(array for lanes in shares.placed for array in lanes),
        shares.gradient_sums,
        shares.value_sums,
        shares.nowhere,
        shares.cleared,
        shares.cleared_ends,
    )
    none = np.zeros(0, dtype=np.int64)
    gradient = _Copies(
        "gradient", shares.gradient_sums, pattern.size, trash, shares.gradient_extent, none
    )
    values = _Copies(
        "values",
        shares.value_sums,
        pattern.value_count,
        trash**2,
        shares.value_extent,
        shares.nowhere,
    )
    require(
        len(shares.nowhere) == shares.count and len(set(shares.nowhere.tolist())) == shares.count,
        "copies",
        "shares have one trash",
    )
    written: list[NDArray[Any]] = []
    for g, group in enumerate(groups):
        block_of_lanes = _check_partition(g, group, placements[g], execution, shares)
        written += _check_offsets(
            g, group, entities, placements[g], shares, block_of_lanes, gradient, values, pattern
        )
        _check_runs(group, len(placements[g].rows), shares.placed[g])
    _check_cleared(shares)
    _check_separate_and_firsts(groups, execution, shares, written)


class _Copies:
    """Copies of targets by the offset of each of their scalars."""

    def __init__(
        self, name: str, sums: Ints, own: int, trash: int, extent: int, nowhere: Ints
    ) -> None:
        self.own = own
        target = np.arange(extent)
        taken = np.zeros(extent, dtype=bool)
        taken[: own + trash] = True
        for to, begin, count in sums.tolist():
            inside = count > 0 and begin >= own + trash and begin + count <= extent
            require(inside, "copies", f"a copy of {name} lies outside of its range")
            require(0 <= to <= own - count, "copies", f"a copy of {name} has no target")
            require(~taken[begin : begin + count], "copies", f"copies of {name} overlap")
            taken[begin : begin + count] = True
            target[begin : begin + count] = np.arange(to, to + count)
        for begin in nowhere.tolist():
            if begin == own:
                continue
            end = begin + trash
            require(begin >= own + trash and end <= extent, "copies", f"trash of {name}")
            require(~taken[begin:end], "copies", f"trash and copies of {name} overlap")
            taken[begin:end] = True
        ordered = sums[np.lexsort((sums[:, 1], sums[:, 0]))] if len(sums) else sums
        require(np.array_equal(ordered, sums), "copies", f"sums of {name} are not in order")
        self.target, self.taken = target, taken


def _check_partition(
    g: int, group: Group, p: Placement, execution: Execution, shares: Shares
) -> Ints:
    """(n,) share of each instance, in the order of lanes."""
    n, width = len(p.rows), execution.widths[g]
    blocks = -(-n // width)
    bounds, order = shares.bounds[g], shares.orders[g]
    label = group.label
    require(
        len(bounds) == shares.count + 1 and bounds[0] == 0 and bounds[-1] == blocks,
        "partition",
        f"the shares of `{label}` are not all its instances",
    )
    require(np.diff(bounds) >= 0, "partition", f"shares of `{label}` overlap")
    if order is not None:
        require(
            np.array_equal(np.sort(order), np.arange(n)),
            "partition",
            f"the order of `{label}` does not have each instance once",
        )
    if not execution.concurrent[g]:
        require(np.count_nonzero(np.diff(bounds)) <= 1, "partition", f"`{label}` is split")
    require(
        all(len(array) == blocks for array in shares.placed[g]),
        "partition",
        f"`{label}` has other blocks of lanes than instances",
    )
    ends = np.minimum(n, bounds * width)
    return np.repeat(np.arange(shares.count), np.diff(ends))


def _by_instance(array: NDArray[Any], n: int) -> NDArray[Any]:
    """(n, k) of what is in lane order; padding must repeat the last instance."""
    blocks, k, width = array.shape
    flat = array.transpose(0, 2, 1).reshape(blocks * width, k)
    require(flat[n:] == flat[n - 1 : n], "offsets", "padded lanes add elsewhere")
    return flat[:n]


def _check_offsets(
    g: int,
    group: Group,
    entities: Sequence[Entity],
    p: Placement,
    shares: Shares,
    share: Ints,
    gradient: _Copies,
    values: _Copies,
    pattern: BlockPattern,
) -> list[NDArray[Any]]:
    """Compare with the placement; return (m, 6) writes: offset, area, share, group, block, pair."""
    n, lanes, order = len(p.rows), shares.placed[g], shares.orders[g]
    if not n:
        return []
    rows, at, block_at, turn = p.arrays(order)
    label = group.label
    require(_by_instance(lanes.row, n) == rows, "offsets", f"rows of `{label}`")
    require(_by_instance(lanes.turn, n) == turn, "offsets", f"orientations of `{label}`")
    found, places = _by_instance(lanes.gradient_at, n), _by_instance(lanes.block_at, n)
    in_range = (found >= 0) & (found < shares.gradient_extent)
    require(in_range, "offsets", f"the gradient of `{label}` is out of range")
    in_range = (places >= 0) & (places < shares.value_extent)
    require(in_range, "offsets", f"the blocks of `{label}` are out of range")
    solved = at != pattern.size
    require(
        gradient.target[found][solved] == at[solved],
        "offsets",
        f"lanes of `{label}` add to another scalar than their instances",
    )
    trash = ~gradient.taken[found] | (found == pattern.size)
    require(trash[~solved], "offsets", f"lanes of `{label}` add what is not solved for")
    nowhere = block_at == pattern.value_count
    require(
        values.target[places][~nowhere] == block_at[~nowhere],
        "offsets",
        f"lanes of `{label}` add to another block than their instances",
    )
    require(
        (places == np.append(shares.nowhere[-1:], shares.nowhere[:-1])[share][:, None])[nowhere],
        "offsets",
        f"lanes of `{label}` add what is not solved for",
    )
    width = lanes.row.shape[2]
    block = np.arange(n) // width
    writes = []
    tangent = [entities[use.entity].tangent for use in group.uses]
    for a in range(len(tangent)):
        for b in range(a + 1):
            pair = pair_of(a, b)
            real = ~nowhere[:, pair]
            count = int(real.sum())
            writes.append(
                np.stack(
                    (
                        places[real, pair],
                        np.full(count, tangent[a] * tangent[b]),
                        share[real],
                        np.full(count, g),
                        block[real],
                        np.full(count, pair),
                    ),
                    axis=1,
                )
            )
    return writes


def _check_runs(group: Group, n: int, lanes: LaneTargets) -> None:
    width = lanes.row.shape[2]
    full = np.arange(len(lanes.row)) < n // width
    rows = lanes.row[:, list(group.lead)]
    same = (rows == rows[:, :, :1]).all(axis=(1, 2)) & full & bool(group.lead)
    require(lanes.run.astype(bool) <= same, "runs", f"blocks of lanes of `{group.label}`")


def _check_cleared(shares: Shares) -> None:
    cleared, ends = shares.cleared, shares.cleared_ends
    if len(cleared):
        inside = cleared[0, 0] >= 0 and cleared[-1, 1] <= shares.value_extent
        require(inside, "cleared", "ranges lie outside of the values")
    require(cleared[:, 0] < cleared[:, 1], "cleared", "a range is empty")
    require(cleared[1:, 0] >= cleared[:-1, 1], "cleared", "ranges overlap")
    require(
        len(ends) == shares.count + 1
        and ends[0] == 0
        and ends[-1] == len(cleared)
        and (np.diff(ends) >= 0).all(),
        "cleared",
        "the shares do not zero each range once",
    )


def _check_separate_and_firsts(
    groups: Sequence[Group], execution: Execution, shares: Shares, written: list[NDArray[Any]]
) -> None:
    zeroed = np.zeros(shares.value_extent, dtype=bool)
    for begin, end in shares.cleared.tolist():
        zeroed[begin:end] = True
    overwritten = np.zeros(shares.value_extent, dtype=bool)
    writes = np.concatenate(written) if written else np.zeros((0, 6), dtype=np.int64)
    # Groups that are left whole run after all others, one after the other.
    whole = ~np.array(execution.concurrent, dtype=bool) if shares.count > 1 else None
    late = whole[writes[:, 3]] if whole is not None else np.zeros(len(writes), dtype=bool)
    at, area, share = writes[:, 0], writes[:, 1], writes[:, 2]
    order = np.lexsort((writes[:, 4], writes[:, 3], late, at))
    same = np.diff(at[order]) == 0
    pairs = same & ~late[order][1:] & ~late[order][:-1]
    require(np.diff(share[order])[pairs] == 0, "separate", "two shares write to the same block")
    first = np.array(
        [shares.placed[g].first[k, pair] for g, k, pair in writes[:, 3:].tolist()], dtype=bool
    )
    for g, group in enumerate(groups):
        may = execution.overwrites[g] or not shares.placed[g].first.any()
        require(may, "firsts", f"`{group.label}` cannot overwrite")
    opens = np.append(True, ~same)[: len(order)]
    require(~first[order] | opens, "firsts", "a first writer follows another writer")
    # Lanes of one block write together: the next write of the same block of lanes is not later.
    again = same & (np.diff(writes[order][:, 3:5], axis=0) == 0).all(axis=1)
    require(~(first[order][:-1] & again), "firsts", "a block of lanes overwrites a block twice")
    turned = np.array(
        [DIAGONAL in shares.placed[g].turn[k, pair] for g, k, pair in writes[first, 3:].tolist()]
    )
    require(~turned.astype(bool), "firsts", "a diagonal block is overwritten")
    for begin, count in zip(at[first].tolist(), area[first].tolist(), strict=True):
        overwritten[begin : begin + count] = True
    require(zeroed | overwritten, "cleared", "values are neither zeroed nor overwritten")
