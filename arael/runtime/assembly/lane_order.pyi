"""The order of a group's instances, and where they add in the order of lanes."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int64]
Bytes = NDArray[np.uint8]

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
