from numpy import int64
from numpy.typing import NDArray

Ints = NDArray[int64]

def join_siblings(
    start: Ints, parent: Ints, row_start: Ints, rows: Ints, weights: Ints
) -> Ints: ...
