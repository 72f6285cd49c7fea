"""Connected components of a graph, by union-find, and what belongs to each of them."""

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int64]

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
