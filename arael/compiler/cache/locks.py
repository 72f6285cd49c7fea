"""Locks of cache entries between processes: one compiles, others wait or skip the entry.

Lock files are never removed: if one were removed while others wait for it, two processes could hold
the lock. There are at most 256, as a lock is named by the first two digits of a key.
"""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterator

from arael.compiler import progress
from arael.compiler.cache.trust import prepare, unwritable
from arael.compiler.time_limit import compile_limit
from arael.diagnostics.records import AraelError, Diagnostic

MARGIN = 120.0
"""Seconds of waiting beyond the longest time that a compiler may take."""


@contextlib.contextmanager
def locked(key: str, limit: float | None = None) -> Iterator[bool]:
    """Hold the lock of `key`.

    Parameters
    ----------
    limit : seconds of waiting, 0 to try once; None waits as long as a compilation may take

    Yields
    ------
    Whether the lock is held; false only where `limit` is given and has passed.

    Raises
    ------
    AraelError
        E0804 the cache cannot be written, E0806 another process holds the lock for too long.
    """
    # imported here: start-up time
    from filelock import FileLock, Timeout

    path = prepare("arael-locks") / f"{key[:2]}.lock"
    lock = FileLock(path, mode=0o600)
    patience = compile_limit() + MARGIN if limit is None else limit
    began = time.monotonic()
    with progress.step("waiting for another process that compiles", patience) as note:
        while True:
            try:
                lock.acquire(timeout=min(1.0, patience), poll_interval=0.02)
                break
            except Timeout:
                waited = time.monotonic() - began
                note(waited)
                if waited < patience:
                    continue
            except OSError as error:
                raise unwritable(error) from error
            if limit is None:
                raise _too_long(str(path), patience)
            yield False
            return
    try:
        yield True
    finally:
        lock.release()


def _too_long(path: str, waited: float) -> AraelError:
    return AraelError(
        Diagnostic(
            "E0806",
            f"waited {waited / 60:.0f} minutes for another process that compiles a model",
            origin=path,
            help=("look for another arael or Python process and end it",),
        )
    )
