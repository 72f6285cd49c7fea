"""Arrays for the solvers' kernels: aligned to cache lines and padded."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import accumulate

import numpy as np
from numpy.typing import DTypeLike, NDArray

from arael.runtime.store.rearranged import aligned_empty

Ints = NDArray[np.int64]

LINE = 64

# Minimum cache lines of a column for conflicts to matter.
_TALL = 16


def aligned(count: int, dtype: DTypeLike) -> NDArray[np.generic]:
    """Zeros, `count` scalars and a cache line of padding, aligned to a cache line."""
    size = np.dtype(dtype).itemsize
    raw = np.zeros(count * size + 3 * LINE, dtype=np.uint8)
    skip = -raw.__array_interface__["data"][0] % LINE
    slack = LINE // size
    return raw[skip : skip + (count + slack) * size].view(dtype)


def aligned_parts(counts: Sequence[int], dtype: DTypeLike) -> list[NDArray[np.generic]]:
    """Arrays of undefined content, each as of `aligned`, in one piece of memory.

    For what is written before it is read: to empty a megabyte takes as long as to factorise it.
    """
    kind = np.dtype(dtype)
    slack = LINE // kind.itemsize
    ends = [0, *accumulate(-(-count // slack) * slack + slack for count in counts)]
    raw = aligned_empty((ends[-1],), kind)
    return [raw[begin : begin + count + slack] for begin, count in zip(ends, counts, strict=False)]


def leading(rows: Ints | int, pad: int) -> Ints | int:
    """Leading dimension for matrices of the given rows: padded, and without cache conflicts.

    Columns an even number of cache lines apart map to few sets of a cache; for tall matrices an odd
    number is used.

    Parameters
    ----------
    rows : int or array of int
    pad : int
        Scalars of a cache line.
    """
    lines = -(-rows // pad)
    return (lines + (lines > _TALL) * ((lines + 1) % 2)) * pad
