"""Progress of what takes seconds: compiling, waiting for another process.

Nothing is printed here. The command line sets `listener`; other programs hear of compilations
through the logger ``arael.compile``.
"""

from __future__ import annotations

import contextlib
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
