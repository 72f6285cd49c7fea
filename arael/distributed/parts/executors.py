"""Where requests are answered: in this process, or by the workers of a Dask cluster."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from itertools import count
from typing import Any, Protocol
from uuid import uuid4

from arael.compiled_model import CompiledModel, warn_of_machine
from arael.diagnostics.records import AraelError, Diagnostic
from arael.distributed.parts.requests import name_here

_FRESH = 0.5
"""Seconds for which the list of workers is taken as it was."""


class Executor(Protocol):
    """Answers requests; what `submit` returns may be an argument of further ones."""

    def ship(self, compiled: CompiledModel) -> str:
        """Make a model known where requests are answered; the name that recipes have for it."""

    def submit(self, function: Callable[..., Any], *args: Any, part: int = -1) -> Any:
        """Ask for ``function(*args)``, where the part of that number is, if possible."""

    def gather(self, found: Sequence[Any]) -> list[Any]:
        """Wait for answers."""


class InProcess:
    """All parts in this process, one after another: for tests, and for what fits."""

    def __init__(self) -> None:
        self._models: list[CompiledModel] = []

    def ship(self, compiled: CompiledModel) -> str:
        """Name the model, which is kept for as long as this object."""
        self._models.append(compiled)
        return name_here(compiled)

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
        self._workers: list[str] = []
        self._asked = float("-inf")

    def ship(self, compiled: CompiledModel) -> str:
        """Send the compiled model to all workers; its SHA-256.

        Raises
        ------
        AraelError
            E0882 a worker has no arael, or another version.

        Warns
        -----
        InterpretedWarning
            Workers run the model on the expression machine, and were not asked to.
        """
        # imported here: start-up time
        from arael.distributed.compiled import ship
        from arael.loading import class_of

        with self._connected():
            shipped = ship(self.client, class_of(compiled))
        assert compiled.recipe is not None
        if shipped.interpreted and compiled.recipe.interpret is not True:
            worker, why = next(iter(shipped.interpreted.items()))
            warn_of_machine(f"worker {worker}: {why}", 5)
        return shipped.hash

    def submit(self, function: Callable[..., Any], *args: Any, part: int = -1) -> Any:
        """Submit a task under a name of its own."""
        with self._connected():
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
        with self._connected():
            return list(self.client.gather(list(found)))

    def _present(self) -> list[str]:
        """Addresses of the workers, asked for now and then: a question takes a round trip."""
        now = time.monotonic()
        if now - self._asked > _FRESH:
            self._workers = sorted(self.client.scheduler_info(n_workers=-1).get("workers", {}))
            self._asked = now
        return self._workers

    @contextmanager
    def _connected(self) -> Iterator[None]:
        """Report a lost cluster by a message; E0898."""
        # imported here: start-up time
        from concurrent.futures import CancelledError

        from distributed.comm.core import CommClosedError
        from distributed.scheduler import KilledWorker

        try:
            if self.client.status in ("closing", "closed"):
                raise OSError("the connection is closed")
            yield
        except AraelError:
            raise
        except KilledWorker as error:
            raise AraelError(
                Diagnostic(
                    "E0898",
                    "several workers died with the same part",
                    origin="cluster",
                    notes=(" ".join(str(error).split()),),
                    help=("is a part too large for the memory of a worker? take more parts",),
                )
            ) from None
        except (CancelledError, CommClosedError, OSError, TimeoutError) as error:
            raise AraelError(
                Diagnostic(
                    "E0898",
                    "the scheduler of the cluster is lost",
                    origin="cluster",
                    notes=(f"{type(error).__name__}: {error}",),
                    help=("go on with `--resume`, if there is a checkpoint",),
                )
            ) from None

    def _home(self, part: int) -> str | None:
        workers = self._present()
        if not workers:
            return None
        known = self._homes.get(part)
        if known not in workers:
            taken = list(self._homes.values())
            known = min(workers, key=lambda w: (taken.count(w), w))
            self._homes[part] = known
        return known
