import numpy as np
from numpy.typing import NDArray

from arael.runtime.levels.rows import Rows

def components(rows: Rows) -> NDArray[np.int32]: ...
