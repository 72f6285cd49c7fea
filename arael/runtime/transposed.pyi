from typing import Any

import numpy as np
from numpy.typing import NDArray

def spread_rows(
    values: NDArray[Any], lanes: int, order: NDArray[np.int64] | None, found: NDArray[Any]
) -> None: ...
