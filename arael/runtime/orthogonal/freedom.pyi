import numpy as np
from numpy.typing import NDArray

def row_lengths(q: object) -> NDArray[np.float64]: ...
