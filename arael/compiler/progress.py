"""Progress of operations that take seconds: compiling, waiting for another process.

Nothing is printed here. The command line sets `listener`; other programs receive messages about
compilations through the logger ``arael.compile``.
"""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Callable, Iterator

Listener = Callable[[str, float | None, float], None]
"""Called with what is done, the seconds so far (None: it has ended) and the most it may take."""

listener: Listener | None = None


@contextlib.contextmanager
def step(what: str, limit: float) -> Iterator[Callable[[float], None]]:
    """Report a step of at most `limit` seconds; yields what to call with the time so far."""

    def note(seconds: float | None) -> None:
        if listener is not None:
            listener(what, seconds, limit)

    try:
        yield note
    finally:
        note(None)


@contextlib.contextmanager
def watched(what: str, limit: float) -> Iterator[None]:
    """Report a step within this process every second, from a thread."""
    if listener is None:
        yield
        return
    began = time.monotonic()
    done = threading.Event()
    with step(what, limit) as note:

        def report() -> None:
            while not done.wait(1.0):
                note(time.monotonic() - began)

        task = threading.Thread(target=report, daemon=True)
        task.start()
        try:
            yield
        finally:
            done.set()
            task.join()
