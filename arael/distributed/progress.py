"""The progress of many problems: in the cell of a notebook, or on a terminal."""

from __future__ import annotations

import time
from collections.abc import Callable

from arael.display.progress import DELAY, INTERVAL
from arael.distributed.work import Row


class Solved:
    """One line that counts the problems that have ended.

    Parameters
    ----------
    count : of all problems
    show : takes the text to be shown in place of the text before; None: nothing is shown
    dashboard : address of Dask's dashboard, or None
    delay, interval : seconds before the first text, and between texts
    """

    def __init__(
        self,
        count: int,
        show: Callable[[str], object] | None,
        dashboard: str | None,
        delay: float = DELAY,
        interval: float = INTERVAL,
    ) -> None:
        self._count = count
        self._show = show
        self._dashboard = dashboard
        self._interval = interval
        self._began = time.monotonic()
        self._next = self._began + delay
        self._ended = self._failed = 0
        self._shown = False

    def add(self, row: Row) -> None:
        """Count a problem that has ended."""
        self._ended += 1
        self._failed += not row.converged
        now = time.monotonic()
        if self._show is not None and now >= self._next:
            self._next = now + self._interval
            self._shown = True
            self._show(self._text(now - self._began))

    def _text(self, seconds: float) -> str:
        parts = [f"{self._ended} of {self._count} problems", f"{seconds:.1f} s"]
        if self._failed:
            parts.insert(1, f"{self._failed} not converged")
        if self._dashboard is not None:
            parts.append(f"dashboard {self._dashboard}")
        return ", ".join(parts)

    def clear(self) -> None:
        """Remove the line."""
        if self._show is not None and self._shown:
            self._shown = False
            self._show("")
