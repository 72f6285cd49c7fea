"""E1235: what a person has broken off."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from arael.diagnostics.records import AraelError, Diagnostic
from arael.runtime.compiled import InterruptedWork


def broken_off() -> AraelError:
    """E1235: a solve or a verdict that was made to end."""
    return AraelError(
        Diagnostic(
            "E1235",
            "broken off before a solution was found",
            notes=("the sketch is left as it was",),
        )
    )


@contextmanager
def breakable() -> Iterator[None]:
    """Work in compiled loops: E1235 where they were broken off."""
    try:
        yield
    except InterruptedWork:
        raise broken_off() from None
