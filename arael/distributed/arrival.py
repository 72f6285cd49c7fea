"""The Dask plugin by which compiled models arrive at workers."""

from __future__ import annotations

from distributed import Worker, WorkerPlugin

from arael.distributed.contents import arrive, forget


class Arrival(WorkerPlugin):  # type: ignore[misc, unused-ignore]
    """Hands content of a vouched hash to each worker when it joins."""

    def __init__(self, vouched: str, data: bytes) -> None:
        self.vouched = vouched
        self.data = data

    def setup(self, worker: Worker) -> None:
        """Verify and keep the content; see `arael.distributed.contents.arrive`."""
        arrive(self.vouched, self.data)

    def teardown(self, worker: Worker) -> None:
        """Drop the content."""
        forget(self.vouched)
