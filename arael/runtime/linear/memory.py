"""Arrays for the solvers' kernels: aligned to cache lines, with room behind."""

from __future__ import annotations

import numpy as np
from numpy.typing import DTypeLike, NDArray

Ints = NDArray[np.int64]

LINE = 64

# Lines of a column from which conflicts matter.
_TALL = 16


def aligned(count: int, dtype: DTypeLike) -> NDArray[np.generic]:
    """Zeros, `count` scalars and a cache line of slack, beginning on a cache line."""
    size = np.dtype(dtype).itemsize
    raw = np.zeros(count * size + 3 * LINE, dtype=np.uint8)
    skip = -raw.__array_interface__["data"][0] % LINE
    slack = LINE // size
    return raw[skip : skip + (count + slack) * size].view(dtype)


def leading(rows: Ints | int, pad: int) -> Ints | int:
    """Leading dimension for matrices of so many rows: padded, and without conflicts in the caches.

    Columns an even number of cache lines apart crowd into few sets of a cache; in tall matrices an
    odd number is worth a line more.

    Parameters
    ----------
    rows : int or array of int
    pad : int
        Scalars of a cache line.
    """
    lines = -(-rows // pad)
    return (lines + (lines > _TALL) * ((lines + 1) % 2)) * pad
