import numpy as np
from numpy.typing import NDArray

def rows_of_handles(
    handles: NDArray[np.int64],
    positions: NDArray[np.int64],
    generations: NDArray[np.int64],
    start: int,
    shift: int,
) -> NDArray[np.int64]: ...
