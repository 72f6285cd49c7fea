"""Where parts live: one Dask actor on each worker, which answers requests about its parts.

The calling process asks it directly, or through the scheduler where it does not reach workers; the
worker with the boundary asks those with the parts. A request and its answer are one message each.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from dataclasses import dataclass
from functools import partial
from typing import Any

from arael.distributed.parts.requests import Answer, answer, solve_boundary

POLL = 1.0
"""Seconds after which it is checked that a worker is still there."""

LOST = "lost"


@dataclass(frozen=True)
class Letter:
    """A request or an answer, so that it is one object of a message: its arrays are not copied."""

    content: Any


class Station:
    """The actor: a way to the functions of `requests` in the process of a worker.

    Parts are worked on by as many threads as the worker has; the boundary has one of its own, since
    it waits for parts that may be on the same worker.
    """

    def __init__(self) -> None:
        # imported here: start-up time
        from distributed import get_worker

        worker: Any = get_worker()
        self._parts = ThreadPoolExecutor(max(1, worker.state.nthreads))
        self._boundary = ThreadPoolExecutor(1)

    async def answer(self, request: Letter) -> Letter:
        """Answer a request; exceptions are part of the answer."""
        function, args = request.content
        threads = self._boundary if function is solve_boundary else self._parts
        work = partial(copy_context().run, answer, function, args)
        return Letter(await asyncio.get_running_loop().run_in_executor(threads, work))


@dataclass(frozen=True)
class Remote:
    """A station as seen from the calling process or from another worker.

    Attributes
    ----------
    actor : distributed.actor.Actor of a `Station`
    address : of its worker
    """

    actor: Any
    address: str

    def start(self, function: Callable[..., Any], *args: Any) -> Any:
        """Send a request; what is returned goes to `wait`."""
        try:
            return self.actor.answer(Letter((function, args)))
        except RuntimeError as error:  # of Dask: the worker is known to be lost
            return error

    def wait(self, pending: Any) -> Answer:
        """The answer to a request; ``("lost", why)`` if the worker is."""
        if isinstance(pending, Exception):
            return LOST, pending
        while True:
            try:
                found: Answer = pending.result(timeout=POLL).content
                return found
            except TimeoutError:
                if self.address not in present_workers():
                    return LOST, OSError("the worker has left the cluster")
            except Exception as error:  # of the connection: those of requests are in the answer
                return LOST, error


def present_workers() -> set[str]:
    """Addresses of the workers, as the scheduler has them.

    Raises
    ------
    OSError
        The scheduler is lost.
    """
    # imported here: start-up time
    from distributed import Client, get_worker
    from distributed.utils import sync

    try:
        worker: Any = get_worker()
    except ValueError:
        current: Any = Client.current
        client = current()
        if client.status != "running":
            raise OSError("the connection to the scheduler is lost") from None
        return set(client.sync(client.scheduler.identity)["workers"])
    ask: Any = sync
    return set(ask(worker.loop, worker.scheduler.identity)["workers"])


def ask_directly(client: Any, seconds: float = 2.0) -> None:
    """Let a client send to workers without the scheduler in between, if it reaches one of them."""

    async def reached(address: str) -> Any:
        return await asyncio.wait_for(client.rpc(address).identity(), seconds)

    with client.as_current():
        workers = sorted(present_workers())
    if workers:
        try:
            client.sync(reached, workers[0])
        except OSError:
            return
    client.direct_to_workers = True
