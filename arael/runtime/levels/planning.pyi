import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int32]
Longs = NDArray[np.int64]

def neighbours(
    n: int, indptr: Ints, indices: Ints, free: NDArray[np.uint8], taken: Ints
) -> tuple[Longs, Longs]: ...
def arranged(
    n: int,
    indptr: Ints,
    indices: Ints,
    free: NDArray[np.uint8],
    order: Longs,
    links: tuple[Ints, Ints] | None,
) -> tuple[Ints, ...]: ...
def factor_pattern(
    start: Ints, unknown: Ints, column_start: Ints, column_position: Ints
) -> tuple[Ints, Ints, Ints, Ints]: ...
