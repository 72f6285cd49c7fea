"""Connected components of a graph, by union-find."""

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int64]

def connected(
    column_start: Ints, rows: Ints, ones: Ints, others: Ints, idle: NDArray[np.uint8]
) -> tuple[int, NDArray[np.int32]]: ...
