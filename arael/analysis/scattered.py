"""Numbers without a pattern, the same in every run.

To import NumPy's generators takes longer than to solve a small problem.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def scattered(count: int, turn: int = 0) -> NDArray[np.float64]:
    """(count,) numbers between -1 and 1, others for each `turn`."""
    at = np.arange(1, count + 1) * 12.9898 + (turn + 1) * 78.233
    found: NDArray[np.float64] = np.modf(np.sin(at) * 43758.5453)[0]
    return found
