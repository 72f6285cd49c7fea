"""Worker processes, and this one, as if they had no C compiler."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest


def change(**variables: str | None) -> dict[str, str | None]:
    """Set or delete variables of the environment of this process; what they were."""
    before = {name: os.environ.get(name) for name in variables}
    for name, value in variables.items():
        if value is None:
            os.environ.pop(name, None)
        else:
            os.environ[name] = value
    return before


@contextmanager
def workers_without_compiler(client: Any, cache: Path) -> Iterator[None]:
    """Empty the search path and the cache of all workers."""
    before = client.run(change, PATH="", CC=None, ARAEL_CACHE_DIR=str(cache))
    try:
        yield
    finally:
        client.run(change, **next(iter(before.values())))


def hide_compiler(monkeypatch: pytest.MonkeyPatch, cache: Path) -> None:
    """Empty the search path and the cache of this process."""
    monkeypatch.setenv("PATH", "")
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("ARAEL_CACHE_DIR", str(cache))
