"""Restricts OpenMP in other libraries to the calling thread.

CHOLMOD before version 4 requests four threads explicitly, ignoring `OMP_NUM_THREADS` and
`omp_set_num_threads`. It respects the maximum nesting of parallel regions, which is set to 0.
"""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from contextlib import contextmanager


class OpenMP:
    """The OpenMP runtimes of this process at construction."""

    def __init__(self) -> None:
        # Imported here for start-up time: only CHOLMOD needs it.
        from threadpoolctl import threadpool_info  # type: ignore[import-untyped, unused-ignore]

        found = [one["filepath"] for one in threadpool_info() if one["user_api"] == "openmp"]
        libraries = [ctypes.CDLL(path) for path in found]
        # Microsoft's runtime does not support nesting.
        self._runtimes = [x for x in libraries if hasattr(x, "omp_set_max_active_levels")]

    @contextmanager
    def on_one_thread(self) -> Iterator[None]:
        """Context in which parallel regions entered by this thread run on this thread only."""
        before = [one.omp_get_max_active_levels() for one in self._runtimes]
        for one in self._runtimes:
            one.omp_set_max_active_levels(0)
        try:
            yield
        finally:
            for one, levels in zip(self._runtimes, before, strict=True):
                one.omp_set_max_active_levels(levels)
