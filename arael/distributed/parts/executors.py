"""Where requests are answered: in this process, or by the workers of a Dask cluster."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import Any, NamedTuple, Protocol
from uuid import uuid4

from arael.compiled_model import CompiledModel, warn_of_machine
from arael.diagnostics.records import AraelError, Diagnostic
from arael.distributed.parts.requests import Answer, answer, name_here
from arael.distributed.parts.stations import LOST, POLL, Remote, Station, present_workers

_LOSSES = 4
"""Workers that may be lost with the same request."""

_STATIONS = 20
"""Times that a station is made anew, since its worker died meanwhile."""

_SUSPECT = 5.0
"""Seconds for which a worker that did not answer is asked only where there is no other."""

_PATIENCE = 60.0
"""Seconds that a solve waits for a worker where there is none."""


class Call(NamedTuple):
    """A request of a part.

    Attributes
    ----------
    part : its number, by which the worker is chosen
    thin : arguments for a worker that has what they refer to
    full : makes the arguments for any worker
    """

    part: int
    thin: tuple[Any, ...]
    full: Callable[[], tuple[Any, ...]]


class Executor(Protocol):
    """Answers requests."""

    def ship(self, compiled: CompiledModel) -> str:
        """Make a model known where requests are answered; the name that recipes have for it."""

    def ask(self, function: Callable[..., Any], calls: Sequence[Call]) -> list[Any]:
        """Answers to requests, in their order."""

    def source(self, part: int) -> Any:
        """Where another worker finds a part: an object with `start` and `wait`."""


class InProcess:
    """All parts in this process, one after another: for tests, and for what fits."""

    def __init__(self) -> None:
        self._models: list[CompiledModel] = []

    def ship(self, compiled: CompiledModel) -> str:
        """Name the model, which is kept for as long as this object."""
        self._models.append(compiled)
        return name_here(compiled)

    def ask(self, function: Callable[..., Any], calls: Sequence[Call]) -> list[Any]:
        """Call the function."""
        found = []
        for call in calls:
            kind, value = self.start(function, *call.thin)
            for _ in range(_LOSSES):
                if kind != "unknown":
                    break
                kind, value = self.start(function, *call.full())
            if kind == "raised":
                raise value
            if kind != "known":
                raise lost_too_often("a part is lost in this process")
            found.append(value)
        return found

    def source(self, part: int) -> InProcess:
        """Return the object itself."""
        return self

    def start(self, function: Callable[..., Any], *args: Any) -> Answer:
        """Answer a request."""
        return answer(function, args)

    def wait(self, pending: Answer) -> Answer:
        """Return what was answered."""
        return pending


class OnDask:
    """Requests of stations on the workers of a Dask client; see `stations`.

    Each part has a worker that its requests go to, and that has its rows and factor. If it is lost,
    another one takes over, which gets the next request of the part with all that it takes. An
    answer counts once: that of a worker that was taken for lost is not waited for any more.

    Parameters
    ----------
    client : distributed.Client; with ``direct_to_workers=True`` vectors go to the workers without
        passing through the scheduler
    """

    def __init__(self, client: Any) -> None:
        self.client = client
        self._homes: dict[int, str] = {}
        self._settled: dict[int, str] = {}
        self._stations: dict[str, tuple[Remote, Any]] = {}
        self._suspects: dict[str, float] = {}

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
            for left in reversed(range(_LOSSES)):
                try:
                    shipped = ship(self.client, class_of(compiled))
                    break
                except OSError:  # a worker has died meanwhile, or the scheduler
                    if not left or self.client.status != "running":
                        raise
        assert compiled.recipe is not None
        if shipped.interpreted and compiled.recipe.interpret is not True:
            worker, why = next(iter(shipped.interpreted.items()))
            warn_of_machine(f"worker {worker}: {why}", 5)
        return shipped.hash

    def ask(self, function: Callable[..., Any], calls: Sequence[Call]) -> list[Any]:
        """Send all requests, and wait for the answers."""
        with self._connected():
            found, raised = self._ask(function, calls)
        if raised is not None:
            raise raised
        return found

    def source(self, part: int) -> Remote:
        """The station of a part's worker, or of another one if that is lost."""
        with self._connected():
            return self._station(part)

    def _ask(
        self, function: Callable[..., Any], calls: Sequence[Call]
    ) -> tuple[list[Any], Exception | None]:
        """Answers, or the first exception that a request raised."""
        found: dict[int, Any] = {}
        losses = [0] * len(calls)
        full: set[int] = set()
        left = list(range(len(calls)))
        while left:
            started = []
            for k in left:
                part = calls[k].part
                station = self._station(part)
                known = k not in full and self._settled.get(part) == station.address
                args = calls[k].thin if known else calls[k].full()
                started.append((k, part, station, station.start(function, *args)))
            left = []
            for k, part, station, pending in started:
                kind, value = station.wait(pending)
                if kind == "raised":
                    return [], value
                if kind == "known":
                    found[k] = value
                    self._settled[part] = station.address
                    continue
                left.append(k)
                full.add(k)
                if kind == LOST:
                    self._forget(station.address)
                    losses[k] += 1
                    if losses[k] > _LOSSES:
                        raise lost_too_often(f"{type(value).__name__}: {value}")
        return [found[k] for k in range(len(calls))], None

    def _station(self, part: int) -> Remote:
        why: Exception | None = None
        for _ in range(_STATIONS):
            home = self._home(part)
            if home in self._stations:
                return self._stations[home][0]
            future = self.client.submit(
                Station,
                actor=True,
                workers=[home],
                allow_other_workers=False,
                key=f"arael-station-{uuid4().hex}",
                pure=False,
            )
            wait: Any = distributed_wait()
            while future.status == "pending" and home in present_workers():
                with suppress(TimeoutError):
                    wait([future], timeout=POLL)
            try:
                if future.status == "pending":
                    raise OSError("the worker has left the cluster")
                self._stations[home] = Remote(future.result(timeout=10 * POLL), home), future
                return self._stations[home][0]
            except Exception as error:  # it died before it could be asked
                why = error
            future.cancel()
            self._forget(home)
        raise lost_too_often(f"{type(why).__name__}: {why}")

    def _forget(self, worker: str) -> None:
        """Choose other workers for the parts of one that does not answer, if there are others."""
        self._stations.pop(worker, None)
        self._suspects[worker] = time.monotonic()
        for kept in (self._homes, self._settled):
            for part in [part for part, home in kept.items() if home == worker]:
                del kept[part]

    def _home(self, part: int) -> str:
        known = self._homes.get(part)
        if known is not None:
            return known
        until = time.monotonic() + _PATIENCE
        while True:
            now = time.monotonic()
            workers = present_workers()
            trusted = {w for w in workers if now - self._suspects.get(w, -_SUSPECT) >= _SUSPECT}
            taken = list(self._homes.values())
            # One that has just failed to answer is asked again only where there is no other.
            choice = trusted or (workers if now > until - _PATIENCE + _SUSPECT else set())
            if choice:
                self._homes[part] = min(choice, key=lambda w: (taken.count(w), w))
                return self._homes[part]
            if now > until:
                raise no_workers()
            time.sleep(0.1)

    @contextmanager
    def _connected(self) -> Iterator[None]:
        """Report a lost cluster by a message; E0898."""
        # imported here: start-up time
        from concurrent.futures import CancelledError

        try:
            if self.client.status != "running":
                raise OSError("the connection is closed")
            with self.client.as_current():
                yield
        except AraelError:
            raise
        except (CancelledError, OSError, TimeoutError) as error:
            raise AraelError(
                Diagnostic(
                    "E0898",
                    "the scheduler of the cluster is lost",
                    origin="cluster",
                    notes=(f"{type(error).__name__}: {error}",),
                    help=("go on with `--resume`, if there is a checkpoint",),
                )
            ) from None


def lost_too_often(why: str) -> AraelError:
    """E0898 for a part whose workers are lost again and again."""
    return AraelError(
        Diagnostic(
            "E0898",
            "several workers died with the same part",
            origin="cluster",
            notes=(why,),
            help=("is a part too large for the memory of a worker? take more parts",),
        )
    )


def no_workers() -> AraelError:
    """E0898 for a cluster without workers."""
    return AraelError(
        Diagnostic(
            "E0898",
            f"the cluster had no worker for {_PATIENCE:g} s",
            origin="cluster",
            help=(
                "start workers: dask worker ADDRESS; go on with `--resume`, if there is a "
                "checkpoint",
            ),
        )
    )


def distributed_wait() -> Any:
    """`distributed.wait`."""
    # imported here: start-up time
    from distributed import wait

    return wait
