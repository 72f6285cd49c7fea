"""One line that is kept up to date: of a solve, of a compilation, of many problems."""

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
"""Seconds between two updates."""
_NOTHING: AbstractContextManager[None] = nullcontext()


class Line:
    """A line of text that changes with time.

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
        self._shown = False

    def update(self, text: Callable[[float], str]) -> None:
        """Show the text of the seconds that have passed, if it is time for a new one."""
        now = time.monotonic()
        if now >= self._next:
            self._next = now + self._interval
            self._shown = True
            self._show(text(now - self._began))

    def clear(self) -> None:
        """Remove the line."""
        if self._shown:
            self._shown = False
            self._show("")


class Progress(Line):
    """An observer of a solve that shows the number of attempts and the cost."""

    _attempts = 0

    def __call__(self, record: Any) -> None:
        """Record one attempted step."""
        self._attempts += 1
        self.update(
            lambda seconds: (
                f"attempt {self._attempts}, cost {float(record['cost']):.6g}, {seconds:.1f} s"
            )
        )

    def with_(self, observer: Callable[[Any], Any] | None) -> Callable[[Any], Any]:
        """An observer that records the attempt and asks another, if there is one."""
        if observer is None:
            return self

        def both(record: Any) -> Any:
            self(record)
            return observer(record)

        return both


class OnTerminal:
    """Shows text in place of the last line of a terminal on stderr."""

    def __init__(self) -> None:
        self._line: Any = None

    def __call__(self, text: str) -> None:
        """Show `text`; "" removes what was shown."""
        if not text:
            if self._line is not None:
                self._line.stop()
                self._line = None
            return
        if self._line is None:
            # imported here: start-up time
            from rich.console import Console
            from rich.progress import Progress as RichProgress
            from rich.progress import TextColumn

            self._line = RichProgress(
                TextColumn("{task.description}", markup=False),
                console=Console(stderr=True),
                transient=True,
                auto_refresh=False,  # no thread of its own beside those of the solve
            )
            self._line.start()
            self._line.add_task("")
        self._line.update(0, description=text, refresh=True)


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
    return OnTerminal() if terminal else None


def _is_notebook() -> bool:
    """Whether this process is the kernel of a notebook."""
    if "IPython" not in sys.modules:
        return False
    shell = sys.modules["IPython"].get_ipython()
    return shell is not None and getattr(shell, "kernel", None) is not None
