"""How many problems a worker gets at once, to be solved in turn.

A task costs the worker, the scheduler and the client several milliseconds, whatever it holds. Short
problems therefore go several to a task, as soon as it is known that they are short.
"""

from __future__ import annotations

import statistics
from collections.abc import Iterable

from arael.distributed.work import Row

SECONDS = 0.4
"""Length of a task of several problems: long beside its cost, short for who waits for results."""

MOST = 50
"""Problems of a task: what is lost at most, and tried again, when one of them ends its worker."""


def sizes(count: int, workers: int, rows: Iterable[Row]) -> list[int]:
    """Problems of each task for the problems that are left.

    Parameters
    ----------
    count : of the problems
    workers : threads of the cluster that solve
    rows : of problems that have ended, which tell how long one takes

    Returns
    -------
    Sizes that add up to `count`. The last tasks are smaller, so that all workers end together.
    """
    times = [sum(row.seconds.values()) for row in rows if row.status != "failed"]
    usual = statistics.median(times) if times else SECONDS
    most = min(MOST, max(1, int(SECONDS / usual))) if usual > 0.0 else MOST
    found = []
    while count > 0:
        share = -(-count // (2 * max(1, workers)))
        found.append(min(most, share))
        count -= found[-1]
    return found
