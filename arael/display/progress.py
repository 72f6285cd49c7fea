"""The progress of a solve that takes over a second."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from importlib import import_module
from typing import Any

DELAY = 1.0
"""Seconds before anything is shown."""
INTERVAL = 0.2
_NOTHING: AbstractContextManager[None] = nullcontext()
"""Seconds between two updates."""


class Progress:
    """An observer of a solve that keeps one line up to date; `clear` removes the line.

    Parameters
    ----------
    show : takes the text to be shown in place of the text before; "" removes it
    delay, interval : seconds before the first text, and between texts
    """

    def __init__(
        self, show: Callable[[str], object], delay: float = DELAY, interval: float = INTERVAL
    ) -> None:
        self._show = show
        self._interval = interval
        self._began = time.monotonic()
        self._next = self._began + delay
        self._attempts = 0
        self._shown = False

    def __call__(self, record: Any) -> None:
        """Record one attempted step."""
        self._attempts += 1
        now = time.monotonic()
        if now >= self._next:
            self._next = now + self._interval
            self._shown = True
            cost = float(record["cost"])
            self._show(f"attempt {self._attempts}, cost {cost:.6g}, {now - self._began:.1f} s")

    def with_(self, observer: Callable[[Any], Any] | None) -> Callable[[Any], Any]:
        """An observer that records the attempt and asks another, if there is one."""
        if observer is None:
            return self

        def both(record: Any) -> Any:
            self(record)
            return observer(record)

        return both

    def clear(self) -> None:
        """Remove the line."""
        if self._shown:
            self._shown = False
            self._show("")


def on_terminal(text: str) -> None:
    """Show text in place of the last line of a terminal on stderr."""
    sys.stderr.write(f"\r\x1b[K{text}")
    sys.stderr.flush()


class InNotebook:
    """Shows text in the output of the cell that runs, in place of the text before."""

    def __init__(self) -> None:
        self._handle: Any = None

    def __call__(self, text: str) -> None:
        """Show `text`; "" removes what was shown."""
        # Imported here: IPython is there in notebooks only.
        display: Any = import_module("IPython.display")
        page = display.HTML(f"<pre>{text}</pre>" if text else "")
        if self._handle is None:
            self._handle = display.display(page, display_id=True)
        else:
            self._handle.update(page)


def shown(wanted: bool | None) -> AbstractContextManager[Progress | None]:
    """Give an observer that shows progress, or None; what it shows is removed at the end.

    Parameters
    ----------
    wanted : None: in notebooks and at an interactive prompt on a terminal only
    """
    found = progress_for(wanted)
    return _NOTHING if found is None else _cleared(found)


@contextmanager
def _cleared(progress: Progress) -> Iterator[Progress]:
    try:
        yield progress
    finally:
        progress.clear()


def progress_for(wanted: bool | None) -> Progress | None:
    """The observer of `shown`."""
    place = place_for(wanted)
    return None if place is None else Progress(place)


def place_for(wanted: bool | None) -> Callable[[str], object] | None:
    """What shows text in place of the text before; None if nothing is to be shown.

    Parameters
    ----------
    wanted : None: in notebooks and at an interactive prompt on a terminal only
    """
    if wanted is False:
        return None
    if "IPython" in sys.modules:
        if _is_notebook():
            return InNotebook()
    elif not wanted and "ps1" not in sys.__dict__:  # of an interactive prompt
        return None
    terminal = sys.stderr is not None and sys.stderr.isatty()
    return on_terminal if terminal else None


def _is_notebook() -> bool:
    """Whether this process is the kernel of a notebook."""
    if "IPython" not in sys.modules:
        return False
    shell = sys.modules["IPython"].get_ipython()
    return shell is not None and getattr(shell, "kernel", None) is not None
