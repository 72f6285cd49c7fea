from collections.abc import Sequence
from typing import Any, Literal, overload

import numpy as np
from numpy.typing import NDArray

from arael.runtime.assembly.pattern import BlockPattern
from arael.runtime.assembly.shares import Shares
from arael.runtime.layout import Group

Ints = NDArray[np.int64]
Bytes = NDArray[np.uint8]

def used_rows(
    ways: list[Ints], blocks: list[Any], n: int, nowhere: int
) -> tuple[NDArray[np.int32], NDArray[np.int32], Ints]: ...
def common_ends(
    now: list[Ints], before: list[Ints], count: int, count_before: int
) -> tuple[int, int]: ...
def add_counts(
    counts: NDArray[np.int32], block_at: Ints, turn: Bytes, nowhere: int, sign: int
) -> bool: ...
def leads_behind(block: Ints, lead: int) -> int: ...
def uses_and_keys(
    groups: Sequence[Group],
    coupled: Sequence[Bytes],
    slot_rows: Sequence[list[Ints]],
    active: Sequence[Ints],
    blocks: Sequence[Any],
    nb: int,
    nowhere: int,
) -> tuple[list[tuple[NDArray[np.int32], NDArray[np.int32], Ints]], Ints, int]: ...
def has_blocks(pattern: BlockPattern, keys: Ints) -> bool: ...
def pattern_arrays(
    sizes: Ints, keys: Ints, by_rows: bool
) -> tuple[Ints, Ints, Ints, Ints, int, int]: ...
def places_of(pattern: BlockPattern) -> Ints: ...
def diagonal_of(pattern: BlockPattern) -> Ints: ...
def rows_and_columns(pattern: BlockPattern, scalars: Ints) -> tuple[Ints, Ints]: ...
@overload
def placed_pairs(
    block: Ints,
    coupled: Bytes,
    pattern: BlockPattern,
    nowhere: int,
    complete: Literal[True] = True,
) -> tuple[Ints, Bytes]: ...
@overload
def placed_pairs(
    block: Ints, coupled: Bytes, pattern: BlockPattern, nowhere: int, complete: Literal[False]
) -> tuple[Ints, Bytes] | None: ...
def find_firsts(
    block_at: list[NDArray[np.int64]],
    turns: list[NDArray[np.uint8]],
    counts: Sequence[int],
    areas: list[list[int]],
    order: Sequence[int],
    may: Sequence[bool],
    nowhere: Any,
    extent: int,
    near: int,
) -> tuple[list[NDArray[np.uint8]], NDArray[np.int64]]: ...
def keys_of(
    rows: NDArray[np.int32],
    lead: int,
    block_at: Ints,
    others: list[int],
    nowhere: int,
) -> Ints: ...
def order_by(keys: Ints) -> Ints | None: ...
def lane_targets(
    arrays: Sequence[NDArray[Any]],
    lanes: int,
    order: Ints | None,
    leads: Sequence[int],
    known: Sequence[NDArray[Any]] | None = None,
    kept: int = 0,
) -> tuple[NDArray[np.int32], NDArray[np.int32], Ints, Bytes, Bytes]: ...
def shared_rows(rows: NDArray[np.int32], leads: Sequence[int], n: int) -> NDArray[np.uint8]: ...

class Totals:
    """What is done to the arrays before and after contributions are added to them."""

    single: bool
    gradient_extent: int
    value_extent: int

    def __init__(
        self,
        plan: Shares,
        held: NDArray[np.int64],
        held_values: NDArray[np.int64],
        diagonal_at: NDArray[np.int64],
        single: bool,
    ) -> None: ...
    def hold_others(self, held: NDArray[np.int64], held_values: NDArray[np.int64]) -> None: ...
    def restrict(
        self, gradient: NDArray[np.int64] | None = None, values: NDArray[np.int64] | None = None
    ) -> None: ...
    def take_arrays(self, other: Totals) -> None: ...
    def kept(self) -> tuple[NDArray[Any], NDArray[Any]]: ...
    def zeros(self) -> tuple[NDArray[Any], NDArray[Any]]: ...

def connected(
    column_start: Ints, rows: Ints, ones: Ints, others: Ints, idle: NDArray[np.uint8]
) -> tuple[int, NDArray[np.int32]]: ...
def labels_of_instances(
    gradient_at: NDArray[np.int32],
    component: NDArray[np.int32],
    none: int,
) -> NDArray[np.int32]: ...
def runs_of_values(
    column_start: Ints, value_start: Ints, labels: NDArray[np.int32], value_count: int
) -> Ints: ...
