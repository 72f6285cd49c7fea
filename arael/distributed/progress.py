"""The progress of many problems: in the cell of a notebook, or on a terminal."""

from __future__ import annotations

from collections.abc import Callable

from arael.display.progress import DELAY, INTERVAL, Line
from arael.distributed.work import Row


class Solved(Line):
    """One line that counts the problems that have ended.

    Parameters
    ----------
    count : of all problems
    show, delay, interval : as of `Line`; None shows nothing
    dashboard : address of Dask's dashboard, or None
    """

    def __init__(
        self,
        count: int,
        show: Callable[[str], object] | None,
        dashboard: str | None,
        delay: float = DELAY,
        interval: float = INTERVAL,
    ) -> None:
        super().__init__(show or str, delay, interval)
        self._count = count
        self._dashboard = dashboard
        self._ended = self._failed = 0

    def add(self, row: Row) -> None:
        """Count a problem that has ended."""
        self._ended += 1
        self._failed += not row.converged
        self.update(self._text)

    def _text(self, seconds: float) -> str:
        parts = [f"{self._ended} of {self._count} problems", f"{seconds:.1f} s"]
        if self._failed:
            parts.insert(1, f"{self._failed} not converged")
        if self._dashboard is not None:
            parts.append(f"dashboard {self._dashboard}")
        return ", ".join(parts)
