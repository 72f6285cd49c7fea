"""Compilations that failed: what was reported, and when to try again.

A failure may be temporary (no space, a process killed by the system), due to the environment (the
compiler compiles nothing at all), or lie in the compiler and these kernels. Only the last two are
remembered, and neither for longer than `LIFETIME`.
"""

from __future__ import annotations

import contextlib
import time
from typing import Literal

import msgspec

from arael.compiler.cache.trust import directory, is_trusted, prepare, replace
from arael.diagnostics.records import AraelError

LIFETIME = 86400.0
"""Seconds after which a compilation is tried again in any case."""


class Failure(msgspec.Struct, frozen=True):
    """A compilation that need not be tried again for now.

    Attributes
    ----------
    message : what to report
    compiler : identity of the compiler that failed; another one is tried at once
    retry : ``probe``: as soon as a small module can be compiled; ``changed``: with another compiler
    made : when, in seconds since 1970
    """

    message: str
    compiler: str
    retry: Literal["probe", "changed"]
    made: float


def find(key: str) -> Failure | None:
    """The failure to compile the kernels of `key`, if there was one lately."""
    path = directory() / "arael-failed" / f"{key}.json"
    if not is_trusted(path):
        return None
    try:
        failure = msgspec.json.decode(path.read_bytes(), type=Failure)
    except (OSError, ValueError):
        return None
    return failure if 0 <= time.time() - failure.made < LIFETIME else None


def store(key: str, report: str, failure: Failure | None) -> None:
    """Keep the report of a failed compilation and, unless it may pass by itself, the failure."""
    with contextlib.suppress(OSError, AraelError):
        folder = prepare("arael-failed")
        replace(folder / f"{key}.log", report.encode("utf-8", "replace"))
        if failure is None:
            (folder / f"{key}.json").unlink(missing_ok=True)
        else:
            replace(folder / f"{key}.json", msgspec.json.encode(failure))


def forget(key: str) -> None:
    """Remove what is kept of a failure: the kernels have been compiled."""
    folder = directory() / "arael-failed"
    with contextlib.suppress(OSError):
        for suffix in (".json", ".log"):
            (folder / f"{key}{suffix}").unlink(missing_ok=True)
