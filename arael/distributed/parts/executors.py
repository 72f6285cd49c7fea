"""Where requests are answered: in this process, or by the workers of a Dask cluster."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import count
from typing import Any, Protocol
from uuid import uuid4


class Executor(Protocol):
    """Answers requests; what `submit` returns may be an argument of further ones."""

    def submit(self, function: Callable[..., Any], *args: Any, part: int = -1) -> Any:
        """Ask for ``function(*args)``, where the part of that number is, if possible."""

    def gather(self, found: Sequence[Any]) -> list[Any]:
        """Wait for answers."""


class InProcess:
    """All parts in this process, one after another: for tests, and for what fits."""

    def submit(self, function: Callable[..., Any], *args: Any, part: int = -1) -> Any:
        """Call the function."""
        return function(*args)

    def gather(self, found: Sequence[Any]) -> list[Any]:
        """Return what was found."""
        return list(found)


class OnDask:
    """Requests as tasks of a Dask client.

    Each part has a worker that its requests go to, so that it keeps its rows and factor; another
    one takes over if that is lost. Dask runs a task again whose worker died, with all that it
    depends on: states and recipes are tasks too.

    Parameters
    ----------
    client : distributed.Client
    """

    def __init__(self, client: Any) -> None:
        self.client = client
        self._homes: dict[int, str] = {}
        self._number = count()
        self._name = uuid4().hex[:12]

    def submit(self, function: Callable[..., Any], *args: Any, part: int = -1) -> Any:
        """Submit a task under a name of its own."""
        home = self._home(part)
        return self.client.submit(
            function,
            *args,
            key=f"arael-{function.__name__}-{part}-{self._name}-{next(self._number)}",
            workers=None if home is None else [home],
            allow_other_workers=home is not None,
            pure=False,
        )

    def gather(self, found: Sequence[Any]) -> list[Any]:
        """Wait for the results, each of which counts once."""
        return list(self.client.gather(list(found)))

    def _home(self, part: int) -> str | None:
        workers = sorted(self.client.scheduler_info(n_workers=-1)["workers"])
        if not workers:
            return None
        known = self._homes.get(part)
        if known not in workers:
            taken = list(self._homes.values())
            known = min(workers, key=lambda w: (taken.count(w), w))
            self._homes[part] = known
        return known
