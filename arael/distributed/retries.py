"""Second attempts at problems that failed: after all others, each alone on another worker."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from arael.distributed.work import Task

if TYPE_CHECKING:
    from distributed import Client


@dataclass(frozen=True)
class Going:
    """Problems that were submitted as one task; `worker`: address that was asked for, or None."""

    tasks: list[Task]
    attempt: int
    future: Any
    worker: str | None


class Failed:
    """Problems whose first attempt failed, with the places where that was.

    Dask counts a task that waits at a worker as failed when another one ends that worker. So that
    a second attempt fails for its own sake, it begins on a worker that does nothing else.
    A place is the address of a worker's nanny, which starts the worker anew under another address.
    """

    def __init__(self) -> None:
        self._waiting: list[tuple[Task, str]] = []

    def __bool__(self) -> bool:
        return bool(self._waiting)

    def add(self, task: Task, place: str) -> None:
        """Keep a problem; `place`: where it failed, address of a worker or its nanny, or ""."""
        self._waiting.append((task, place))

    def placed(self, client: Client, going: Iterable[Going]) -> Iterator[tuple[Task, str | None]]:
        """Take the problems that can begin now, each with a free worker or None for any."""
        info: Any = client.scheduler_info
        known = info(n_workers=-1)["workers"]
        places = {address: about.get("nanny") or address for address, about in known.items()}
        busy = {one.worker for one in going}
        free = [address for address in places if address not in busy]
        left = []
        begun = bool(busy)
        for task, failed_at in self._waiting:
            failed_at = places.get(failed_at, failed_at)
            elsewhere = any(place != failed_at for place in places.values())
            fit = [w for w in free if not elsewhere or places[w] != failed_at]
            if fit:
                free.remove(fit[0])
                begun = True
                yield task, fit[0]
            else:
                left.append((task, failed_at))
        if not begun and left:  # no worker is there: the next that joins takes one
            yield left.pop(0)[0], None
        self._waiting = left
