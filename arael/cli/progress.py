"""Progress line of a solve on a terminal."""

from __future__ import annotations

import sys
import time
from typing import Any

INTERVAL = 0.1
"""Seconds between two updates; a solve shorter than this shows nothing."""


class Progress:
    """An observer of the solve that keeps one line on stderr up to date.

    It is shown on a terminal only; `clear` removes the line.
    """

    def __init__(self) -> None:
        self._last = time.monotonic()
        self._attempts = 0
        self._shown = False

    def __call__(self, record: Any) -> None:
        """Record one attempted step."""
        self._attempts += 1
        now = time.monotonic()
        if now - self._last >= INTERVAL:
            self._last = now
            self._shown = True
            sys.stderr.write(f"\r\x1b[Kattempt {self._attempts}, cost {float(record['cost']):.6g}")
            sys.stderr.flush()

    def clear(self) -> None:
        """Remove the line."""
        if self._shown:
            sys.stderr.write("\r\x1b[K")
            sys.stderr.flush()


def progress_wanted(verbose: bool, as_json: bool) -> bool:
    """Whether stderr is a terminal."""
    return not verbose and not as_json and sys.stderr.isatty()
