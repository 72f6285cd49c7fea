"""Arrays for the solvers' kernels: aligned to cache lines, with room behind."""

from __future__ import annotations

import numpy as np
from numpy.typing import DTypeLike, NDArray

LINE = 64


def aligned(count: int, dtype: DTypeLike) -> NDArray[np.generic]:
    """Zeros, `count` scalars and a cache line of slack, beginning on a cache line."""
    size = np.dtype(dtype).itemsize
    raw = np.zeros(count * size + 3 * LINE, dtype=np.uint8)
    skip = -raw.ctypes.data % LINE
    slack = LINE // size
    return raw[skip : skip + (count + slack) * size].view(dtype)
