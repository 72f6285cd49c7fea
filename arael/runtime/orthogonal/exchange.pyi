import numpy as np
from numpy.typing import NDArray

Entries = tuple[NDArray[np.int32], NDArray[np.float64]]

def reduce_by_priority(
    rows: list[Entries], count: int, least: float
) -> list[tuple[int, NDArray[np.int32], NDArray[np.float64]]]: ...
