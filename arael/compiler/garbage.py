"""Garbage collection while a model is compiled."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager

RARELY = 100_000
"""New objects between two collections; 700 to 2000 by default."""


@contextmanager
def rare_collections() -> Iterator[None]:
    """Let the collector of cyclic garbage run rarely; where it is disabled, it stays so.

    SymPy and Cython make many objects that are used to the end, among which it finds nothing. That
    takes a tenth of a compilation.
    """
    before = gc.get_threshold()
    if before[0]:
        gc.set_threshold(max(before[0], RARELY), *before[1:])
    try:
        yield
    finally:
        gc.set_threshold(*before)
