"""Arrays on cache lines."""

from __future__ import annotations

import numpy as np

from arael.runtime.compiled import aligned_empty, aligned_parts


def test_arrays_begin_on_a_cache_line() -> None:
    for count in range(1, 40):
        found = aligned_empty((count, 3), np.dtype(np.float32))
        assert found.shape == (count, 3) and found.dtype == np.float32
        assert found.ctypes.data % 64 == 0 and found.flags.c_contiguous


def test_parts_begin_on_cache_lines_of_their_own_and_are_padded() -> None:
    for dtype, pad in ((np.float64, 8), (np.float32, 16)):
        counts = [0, 1, 7, 8, 9, 100]
        found = aligned_parts(counts, np.dtype(dtype))
        assert [len(part) for part in found] == [count + pad for count in counts]
        for number, part in enumerate(found):
            assert part.ctypes.data % 64 == 0 and part.dtype == dtype
            part[:] = number
        assert all((part == number).all() for number, part in enumerate(found))
