from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

def keys_of(
    rows: NDArray[np.int32],
    lead: int,
    block_at: NDArray[np.int64],
    others: list[int],
    nowhere: int,
) -> NDArray[np.int64]: ...
def order_by(keys: NDArray[np.int64]) -> NDArray[np.int64] | None: ...
def shared_rows(rows: NDArray[np.int32], leads: Sequence[int], n: int) -> NDArray[np.uint8]: ...
