"""A module that local workers load first: Ctrl-C in a terminal is for the command, not for them."""

from __future__ import annotations

import signal
from typing import Any


def dask_setup(worker: Any) -> None:
    """Ignore the interrupt that a terminal sends to all processes; the client ends its workers."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
