from collections.abc import Sequence
from typing import Any, Literal, overload

import numpy as np
from numpy.typing import NDArray

from arael.runtime.assembly.pattern import BlockPattern
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
