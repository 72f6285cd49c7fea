from typing import Any

import numpy as np
from numpy.typing import NDArray

def aligned_empty(shape: tuple[int, ...], dtype: np.dtype[Any]) -> NDArray[Any]: ...
def taken(values: NDArray[Any], component: int, rows: NDArray[np.int64]) -> NDArray[np.float64]: ...
def spread_rows(
    values: NDArray[Any], lanes: int, order: NDArray[np.int64] | None, found: NDArray[Any]
) -> None: ...
