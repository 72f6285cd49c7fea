from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arael.runtime.levels.rows import Rows

def surely_independent(
    rows: Rows,
    x: NDArray[np.float64],
    asked: Sequence[int],
    counts: NDArray[np.bool_],
    *,
    more: Sequence[tuple[Any, Any]] = (),
    scales: NDArray[np.float64] | None = None,
    sizes: Sequence[int] = (8, 24, 64),
) -> bool: ...
