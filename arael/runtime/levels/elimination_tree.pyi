import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int32]

def factor_pattern(
    start: Ints, unknown: Ints, column_start: Ints, column_position: Ints
) -> tuple[Ints, Ints, Ints, Ints]: ...
