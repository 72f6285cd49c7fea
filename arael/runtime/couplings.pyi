from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.linear.pattern import BlockPattern

Ints = NDArray[np.int64]
Bytes = NDArray[np.uint8]

def used_rows(
    ways: list[Ints], blocks: list[Any], n: int, nowhere: int
) -> tuple[NDArray[np.int32], NDArray[np.int32], Ints]: ...
def add_keys(block: Ints, coupled: Bytes, nb: int, keys: Ints, count: int) -> int: ...
def leads_behind(block: Ints, lead: int) -> int: ...
def pattern_arrays(sizes: Ints, keys: Ints, by_rows: bool) -> tuple[Ints, Ints, Ints]: ...
def diagonal_of(pattern: BlockPattern) -> Ints: ...
def placed_pairs(
    block: Ints, coupled: Bytes, pattern: BlockPattern, nowhere: int
) -> tuple[Ints, Bytes]: ...
