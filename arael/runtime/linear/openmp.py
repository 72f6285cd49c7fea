"""OpenMP in other people's libraries, kept to the calling thread.

CHOLMOD before its version 4 asks for four threads by number, whatever `OMP_NUM_THREADS` or
`omp_set_num_threads` say. What it heeds is how deep parallel regions may nest: not at all.
"""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from contextlib import contextmanager


class OpenMP:
    """The OpenMP runtimes in this process when the object is made."""

    def __init__(self) -> None:
        from threadpoolctl import threadpool_info  # type: ignore[import-untyped, unused-ignore]

        found = [one["filepath"] for one in threadpool_info() if one["user_api"] == "openmp"]
        libraries = [ctypes.CDLL(path) for path in found]
        # Microsoft's runtime is older than nesting.
        self._runtimes = [x for x in libraries if hasattr(x, "omp_set_max_active_levels")]

    @contextmanager
    def on_one_thread(self) -> Iterator[None]:
        """Run parallel regions that this thread enters on this thread alone."""
        before = [one.omp_get_max_active_levels() for one in self._runtimes]
        for one in self._runtimes:
            one.omp_set_max_active_levels(0)
        try:
            yield
        finally:
            for one, levels in zip(self._runtimes, before, strict=True):
                one.omp_set_max_active_levels(levels)
