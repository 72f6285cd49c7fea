"""Coroutines run to their end from a test."""

from __future__ import annotations

import asyncio
from collections.abc import Coroutine
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar

T = TypeVar("T")


def completed(main: Coroutine[Any, Any, T]) -> T:
    """What a coroutine returns.

    Its event loop is in a thread of its own: in the test's thread the driver of a browser may have
    one from an earlier test, beside which no other can run.
    """
    with ThreadPoolExecutor(1) as pool:
        return pool.submit(asyncio.run, main).result()
