import numpy as np
from numpy.typing import NDArray

def reduce_by_priority(table: NDArray[np.float64], least: float) -> NDArray[np.int32]: ...
